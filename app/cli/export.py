"""``tsr export`` and ``tsr formats``: export data sets without a server."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

import json as jsons
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.exchange_common import OptionOption, pairs, print_lines
from app.cli.library import HomeOption
from tsr_engine.cli.common import JsonOption, existing, frame_range, out_console, print_json, say
from tsr_engine.errors import UsageError
from tsr_engine.plural import plural

if TYPE_CHECKING:
    from pydantic import ValidationError

    from app.exchange.export import ExportRequest


def formats(json: JsonOption = False) -> None:
    """List the formats of other tools, with their options.

    \b
    Examples:
      tsr formats
      tsr formats --json
    """
    from app.exchange.formats import format_view
    from tsr_engine.exchange.registry import FORMATS

    views = [format_view(each).model_dump(mode="json") for each in FORMATS.values()]
    if json:
        print_json({"formats": views})
        return
    from rich.table import Table

    table = Table("name", "out", "in", "what", "options (the first value is the default)", box=None)
    for view in views:
        options = [
            f"{s['name']}={'|'.join([*s['values'], *(['TEXT'] if s['free'] else [])])}"
            for s in (*view["export_switches"], *view["import_switches"])
        ]
        table.add_row(
            view["name"],
            "yes" if view["can_export"] else "",
            "yes" if view["can_import"] else "",
            view["summary"],
            "\n".join(dict.fromkeys(options)),
        )
    out_console().print(table)


def export(
    names: Annotated[
        list[str],
        typer.Argument(metavar="RUN...", help="Runs: their ids, evidence folders, or videos (their newest run)."),
    ],
    format: Annotated[str, typer.Option("--format", metavar="NAME", help="See 'tsr formats'.")],
    out: Annotated[Path, typer.Option("--out", metavar="OUT", help="A folder, or a file that ends with .zip.")],
    home: HomeOption = None,
    pictures: Annotated[
        str, typer.Option("--pictures", metavar="none|annotated|all", help="Frames to export as pictures.")
    ] = "none",
    states: Annotated[
        str | None,
        typer.Option(
            "--states",
            help="Tracks to export: open, edited (open ones that a person has edited), accepted, needs_work, "
            "rejected (never exported as signs). Unset: edited,accepted,rejected; for an evidence folder all.",
        ),
    ] = None,
    labels: Annotated[
        str | None,
        typer.Option(
            "--labels", metavar="KEY,KEY...", help="Labels to export, by key, name or number; -1: not in the set."
        ),
    ] = None,
    classes: Annotated[
        str | None, typer.Option("--classes", metavar="N,N...", help="The same by number, as in version 0.1.")
    ] = None,
    not_in_set: Annotated[
        str,
        typer.Option(
            "--not-in-set",
            metavar="leave-out|ignore|class",
            help="Signs without a label of the set: leave out, regions to ignore, or a class of their own.",
        ),
    ] = "leave-out",
    class_map: Annotated[
        str,
        typer.Option("--class-map", metavar="all|used", help="Declare all labels of the set, or only exported ones."),
    ] = "all",
    min_side: Annotated[
        float | None, typer.Option("--min-side", metavar="PX", min=0, help="Leave out smaller boxes.")
    ] = None,
    frames: Annotated[str | None, typer.Option("--frames", metavar="A:B", help="Only frames A to B-1.")] = None,
    split: Annotated[
        str | None,
        typer.Option("--split", metavar="TRAIN,VAL[,TEST]", help="Shares, such as 0.8,0.1,0.1; scaled to a sum of 1."),
    ] = None,
    split_by: Annotated[
        str, typer.Option("--split-by", metavar="sign|video", help="Unit that stays on one side of the split.")
    ] = "sign",
    balance_labels: Annotated[
        bool, typer.Option("--balance-labels", help="Give each side of the split every label with enough signs.")
    ] = False,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the split.")] = 0,
    thin: Annotated[float, typer.Option("--thin", metavar="PX", min=0, help="Largest error of interpolation.")] = 0.5,
    options: OptionOption = [],  # noqa: B006 - typer copies it
    video: Annotated[
        Path | None, typer.Option("--video", metavar="FILE", help="The video of a bare evidence folder.")
    ] = None,
    json: JsonOption = False,
) -> None:
    """Write runs with their corrections in the format of another tool.

    An older export of that name stays complete until the new one replaces it.

    \b
    Examples:
      tsr export drive.mp4 --format cvat-video --out drive.zip
      tsr export 3f2a... 77c1... --format yolo --out signs --pictures annotated --split 0.8,0.1,0.1
      tsr export run1 --format mot --out mot.zip --option origin=1
    """
    from pydantic import ValidationError

    from app.cli.progress import step_counter
    from app.cli.run_names import as_command_error, find_sources
    from app.exchange.export import DEFAULT_STATES, ExportRequest, check_request, export_sources, summary_of

    first, stop = frame_range(frames)
    asked: dict[str, object] = {
        "runs": ["0" * 32],  # the option is named RUN here, so the model's field gets a placeholder
        "format": format,
        "pictures": pictures,
        "states": list(DEFAULT_STATES) if states is None else _parts(states),
        "labels": None if labels is None else [labels],
        "classes": None if classes is None else _numbers("--classes", classes),
        "not_in_set": not_in_set,
        "class_map": class_map,
        "balance_labels": balance_labels,
        "min_side": min_side,
        "first": first,
        "stop": stop,
        "split": None if split is None else _shares(split),
        "split_by": split_by,
        "split_seed": seed,
        "thin_px": thin,
        "switches": pairs("--option", options),
    }
    try:
        request: ExportRequest = ExportRequest.model_validate(asked)
    except ValidationError as error:
        raise _usage(error) from None
    check_request(request)
    sources = find_sources(names, home, None if video is None else existing(video, "video"), say)
    if states is None and all(source.run_id is None for source in sources):
        # a bare evidence folder has no reviews
        request = request.model_copy(update={"states": ["open", *DEFAULT_STATES]})
    with step_counter("exporting") as progress, as_command_error():
        manifest = export_sources(request, sources, out, zipped=out.suffix.lower() == ".zip", progress=progress)
    summary = summary_of(manifest)
    if json:
        print_json({"out": str(out), **summary})
        return
    counts = summary["counts"]
    console = out_console()
    rejected = f", {plural(counts['negatives'], 'rejected track')}" if counts["negatives"] else ""
    fell = ", ".join(f"{side} {tracks}" for side, tracks in summary["split"]["tracks"].items())
    console.print(
        f"{out}: {plural(counts['tracks'], 'track')}{fell and f' ({fell})'}{rejected}, "
        f"{plural(counts['boxes'], 'box', 'boxes')}, "
        f"{plural(counts['pictures'], 'picture')} in {plural(summary['files'] + 1, 'file')} ({summary['title']}).",
        soft_wrap=True,
    )
    if summary["open_left"]:
        stay = "stays" if summary["open_left"] == 1 else "stay"
        console.print(
            f"{plural(summary['open_left'], 'open track')} {stay} out: nobody has accepted or edited them yet. "
            "--states open,edited,accepted,rejected includes them.",
            soft_wrap=True,
        )
    for side, words in summary["split"]["lacks"].items():
        console.print(f"{side} has no sign of: {', '.join(words)}.", soft_wrap=True, markup=False)
    print_lines([f"Skipped: {item['what']}. {item['reason']}" for item in manifest.skipped])


def _parts(text: str) -> list[str]:
    return [part.strip() for part in text.split(",") if part.strip()]


def _numbers(option: str, text: str) -> list[int]:
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise UsageError(f"{option} expects whole numbers, for example 14 or 1,2,14. Got '{text}' instead.") from None


def _shares(text: str) -> dict[str, float]:
    try:
        shares = [float(part) for part in text.split(",")]
    except ValueError:
        shares = []
    if not 2 <= len(shares) <= 3:
        raise UsageError(f"--split expects two or three shares, for example 0.8,0.1,0.1. Got '{text}' instead.")
    return dict(zip(("train", "val", "test"), [*shares, 0.0], strict=False))


def _usage(error: ValidationError) -> UsageError:
    """Convert the first invalid value of an export to an error that names its option."""
    first = error.errors()[0]
    place = str(first["loc"][0])
    option = {"split_seed": "seed", "thin_px": "thin"}.get(place, place).replace("_", "-")
    got = jsons.dumps(first["input"]) if not isinstance(first["input"], str) else first["input"]
    return UsageError(f"--{option} cannot be {got[:80]}: {first['msg'][:1].lower()}{first['msg'][1:]}.")
