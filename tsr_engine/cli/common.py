"""Shares messages, settings, parameters, models and tables among the commands."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer
from typer.core import TyperCommand

from tsr_engine.errors import InputError, UsageError

if TYPE_CHECKING:
    from rich.console import Console

    from tsr_engine.params import Params, Reader
    from tsr_engine.pipeline import Network

MAX_SIDE_PX = 16384
"""Pictures are no wider or higher than this, px."""

SetOption = Annotated[
    list[str],
    typer.Option("--set", metavar="NAME=VALUE", help="Change one parameter; may be repeated. The names are below."),
]
PresetOption = Annotated[
    str, typer.Option("--preset", metavar="default|realtime|paper", help="Parameters to start from.")
]
ModelsOption = Annotated[
    Path | None, typer.Option("--models", metavar="DIR", help="Folder of models; unset: the shipped ones.")
]
ReaderOption = Annotated[
    str | None,
    typer.Option(
        "--reader",
        metavar="both|classifier|network",
        help="What classifies: classifier and network together, or one of them; unset: both.",
    ),
]
FormerNetworkOption = Annotated[
    bool, typer.Option("--network-classifier", hidden=True, help="The old name of --reader network.")
]
OnnxOption = Annotated[
    Path | None, typer.Option("--onnx", metavar="FILE", help="Detect with this YOLO-style ONNX network instead.")
]
OnnxSizeOption = Annotated[
    str | None, typer.Option("--onnx-size", metavar="WxH", help="Size of the network's input, px; unset: 640x640.")
]
OnnxLayoutOption = Annotated[
    str | None,
    typer.Option("--onnx-layout", metavar="v8|v5", help="Network's output: v5 has objectness, v8, if unset, has none."),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print the result as JSON for another program.")]


def say(message: str) -> None:
    """Print one sentence on stderr; never fails, whatever the state of the terminal."""
    try:
        sys.stderr.write(f"tsr: {message}\n")
        sys.stderr.flush()
    except (OSError, ValueError):
        pass


def print_json(value: object) -> None:
    """Print standard JSON (no NaN) on stdout."""
    typer.echo(json.dumps(value, indent=1, allow_nan=False, ensure_ascii=False))


def out_console() -> Console:
    """A console on stdout for tables; wide enough not to wrap them if stdout is a file.

    It prints names as they are: ``[front]`` and ``:car:`` in them are neither style nor symbol.
    """
    from rich.console import Console

    return Console(highlight=False, markup=False, emoji=False, width=None if sys.stdout.isatty() else 120)


def make_params(preset: str, settings: Sequence[str]) -> Params:
    """The parameters of a preset, changed by the user's settings.

    Raises:
        UsageError: an unknown preset or name, or a value outside its range.
    """
    from tsr_engine.params import Params

    return Params.preset(preset).with_settings(split_settings(settings))


def split_settings(settings: Sequence[str]) -> list[tuple[str, object]]:
    """``["tau=20", "motion=paper"]`` as pairs; the old name of a parameter gives the present one and a warning.

    Raises:
        UsageError: one of them has no name or no ``=``, or an old switch is neither true nor false.
    """
    from tsr_engine.params.aliases import current_setting, rename_warnings

    pairs = []
    for text in settings:
        name, equals, value = text.partition("=")
        if not equals or not name.strip() or not value.strip():
            raise UsageError(f"--set expects NAME=VALUE, for example --set tau=20. Got '{text}' instead.")
        pairs.append((name.strip(), value.strip()))
    for warning in rename_warnings(name for name, _ in pairs):
        say(warning)
    return [current_setting(name, value) for name, value in pairs]


def size_of(text: str, option: str, example: str) -> tuple[int, int]:
    """Parse ``WxH`` as width and height.

    Raises:
        UsageError: the text has another form, or a number is not positive.
    """
    try:
        width, height = (int(part) for part in text.lower().split("x"))
    except ValueError:
        width = height = 0
    if not (0 < width <= MAX_SIDE_PX and 0 < height <= MAX_SIDE_PX):
        raise UsageError(f"{option} expects WxH, for example {example}. Got '{text}' instead.")
    return width, height


def make_reader(reader: str | None, network: bool = False) -> Reader:
    """What classifies signs, by ``--reader`` or the old ``--network-classifier``, which gives a warning.

    Raises:
        UsageError: another word, or both options.
    """
    from tsr_engine.params import Params

    if network:
        if reader is not None:
            raise UsageError("--network-classifier is now called --reader network. Set one of them, not both.")
        say("--network-classifier is now called --reader network. The old name is refused from the next version on.")
        return "network"
    if reader is None:
        return Params().pipeline.reader
    if reader not in ("both", "classifier", "network"):
        raise UsageError(f"--reader expects both, classifier or network. Got '{reader}' instead.")
    return cast("Reader", reader)


def make_network(path: Path | None, size: str | None, layout: str | None) -> Network | None:
    """The network of the --onnx options; None: no option.

    Raises:
        UsageError: the size or layout is invalid, or no network is named.
    """
    if path is None:
        if size is not None or layout is not None:
            raise UsageError("--onnx-size and --onnx-layout describe a network. Name its file with --onnx.")
        return None
    width, height = (640, 640) if size is None else size_of(size, "--onnx-size", "640x640")
    layout = layout or "v8"
    if layout not in ("v8", "v5"):
        raise UsageError(f"--onnx-layout expects v8 or v5. Got '{layout}' instead.")
    from tsr_engine.pipeline import Network

    return Network(path, (width, height), "v8" if layout == "v8" else "v5")


def frame_range(text: str | None) -> tuple[int, int | None]:
    """Parse ``A:B`` as first frame and the frame after the last; either may be missing.

    Raises:
        UsageError: the text has another form, or the range is empty.
    """
    if text is None:
        return 0, None
    first, colon, last = text.partition(":")
    try:
        start = int(first) if first.strip() else 0
        stop = int(last) if last.strip() else None
    except ValueError:
        colon = ""
    if not colon:
        raise UsageError(f"--frames expects A:B, for example 100:200 or 100:. Got '{text}' instead.")
    if start < 0 or (stop is not None and stop <= start):
        raise UsageError(f"--frames {text} is empty: expected 0 <= A < B, counted from frame 0.")
    return start, stop


def existing(path: Path, what: str) -> Path:
    """Return the path if it exists.

    Raises:
        InputError: it does not exist.
    """
    if not path.exists():
        raise InputError(f"There is no {what} at {path}. Check the path.")
    return path


class ParameterCommand(TyperCommand):
    """A command whose help ends with a table of all parameters."""

    def format_epilog(self, ctx: Any, formatter: Any) -> None:  # Any: typer's parser is private
        """Append one line per parameter: name, default, range."""
        from tsr_engine.params.parameter_table import parameter_rows

        super().format_epilog(ctx, formatter)
        section = ""
        for row in parameter_rows():
            if row["section"] != section:
                section = str(row["section"])
                formatter.write(f"\nParameters for --set, section {section}:\n")
            formatter.write(f"  {row['name']} = {row['default']}  {row['range']}\n")
        formatter.write("\nWhat each of them does: tsr params\n")
