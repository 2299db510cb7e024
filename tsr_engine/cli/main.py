"""Registers the commands of `tsr`, and turns every failure into one sentence and an exit code."""

from __future__ import annotations

import errno
import io
import os
import sys
from collections.abc import Callable, Sequence
from functools import cache
from itertools import pairwise
from typing import Annotated, Any, TextIO

import typer
from typer.core import TyperGroup

from tsr_engine.cli import (
    batch,
    calibrate,
    classify,
    detect,
    doctor,
    evaluate,
    follow,
    params,
    replay,
    sample,
    track,
    train,
)
from tsr_engine.cli.common import ParameterCommand, say
from tsr_engine.cli.interrupt import EXIT_INTERRUPTED, leave_interrupted
from tsr_engine.errors import InputError, StorageError, TsrError, UsageError
from tsr_engine.extras import explained
from tsr_engine.version import __version__

EXIT_UNEXPECTED = 1
EXIT_USAGE = 2
EXIT_BROKEN_PIPE = 141

_FREE_TEXT_OPTIONS = {"--note"}
"""Options with values that may be empty."""

_OUTPUT_OPTIONS = {"--csv", "--evidence", "--jsonl", "--out"}
"""Options that name a file or folder to write in every command that has them."""

_PATH_ERRNOS = (errno.EACCES, errno.EPERM, errno.ENAMETOOLONG, errno.ELOOP)
"""Errors of a path that a command cannot look at: a folder of somebody else, or a name that is too long."""

EPILOG = (
    "Exit codes: 0 done, 2 a wrong option or value, 3 a damaged or missing input, 4 models, 5 an evidence folder, "
    "6 disk, 7 an export that its format cannot hold, 20 and 21 a replayed bug that is not fixed or came out "
    "differently, 22 a check over its budget, 130 interrupted, 141 a pipe that nobody reads, 1 anything unexpected."
)


class _Group(TyperGroup):
    """A command group that handles an interruption."""

    def invoke(self, ctx: Any) -> object:  # Any: typer's parser is private
        """Run the command; Ctrl-C gives a sentence and exit code 130."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            leave_interrupted("No output was written that is not complete.")


app = typer.Typer(
    name="tsr",
    cls=_Group,
    help="Detect, track and classify traffic signs in drive videos, and store why each result is there.",
    epilog=EPILOG,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _version(value: bool) -> None:
    if value:
        typer.echo(f"tsr {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Detect, track and classify traffic signs in drive videos, and store why each result is there."""


app.command("track", cls=ParameterCommand)(track.track)
app.command("batch", cls=ParameterCommand)(batch.batch)
app.command("detect", cls=ParameterCommand)(detect.detect)
app.command("classify")(classify.classify)
app.add_typer(train.app, name="train")
app.add_typer(evaluate.app, name="eval")
app.command("replay", cls=ParameterCommand)(replay.replay)
app.command("follow")(follow.follow)
app.command("calibrate")(calibrate.calibrate)
app.command("sample")(sample.sample)
app.command("params")(params.params)
app.command("doctor")(doctor.doctor)


@cache
def command() -> Callable[..., object]:
    """The command line of ``app``, made once a process; whoever adds a command to ``app`` clears the cache."""
    return typer.main.get_command(app)


def run(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Args:
        arguments: the words after ``tsr``; unset: those of the process.
    """
    _prepare_streams()
    try:
        words = sys.argv[1:] if arguments is None else arguments
        refuse_empty_arguments(words)
        refuse_standard_output(words)
        with explained():
            result = command()(args=arguments, standalone_mode=False)
        sys.stdout.flush()
    except TsrError as error:
        return _report_failure(str(error), error.exit_code)
    except (BrokenPipeError, SystemExit) as error:
        # The reader of a pipe has closed it, as `head` does, so no message is printed. Without this, the parser and
        # tables would end the process with the exit code of an unexpected error.
        if isinstance(error, SystemExit) and not isinstance(error.__context__, BrokenPipeError):
            raise
        sys.stdout = _open_devnull()
        return EXIT_BROKEN_PIPE
    except (KeyboardInterrupt, typer.Abort):
        return _report_failure("Interrupted.", EXIT_INTERRUPTED)
    except Exception as error:
        if hasattr(error, "format_message") and hasattr(error, "exit_code"):
            return _usage_error(error)
        if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
            # Commands report failures of their own outputs; this one is of stdout.
            sys.stdout = _open_devnull()
            full = "The disk is full: output to stdout could not be written. Free some space and run again."
            return _report_failure(full, StorageError.exit_code)
        return _report_failure(*_explain(error))
    return result if isinstance(result, int) else 0


def _prepare_streams() -> None:
    """Replace a closed stdout or stderr by /dev/null, and let stdout escape what its encoding lacks, as stderr does.

    Otherwise the first opened file, such as a database, would get the stream's number and the output of libraries; and
    a file's name that is not UTF-8 would end the command after its work. JSON has the same escape for such a byte.
    """
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, _open_devnull())
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def _open_devnull() -> TextIO:
    return open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123


def refuse_empty_arguments(arguments: Sequence[str]) -> None:
    """Refuse an empty value, such as that of an unset variable: as a path it would mean the current folder.

    Raises:
        UsageError: a value is empty and is not free text.
    """
    for previous, argument in zip(["", *arguments], arguments, strict=False):
        option, equals, value = argument.partition("=")
        if argument and not (option.startswith("--") and equals and not value):
            continue
        option_name = option or (previous if previous.startswith("-") else "")
        if option_name not in _FREE_TEXT_OPTIONS:
            what = f"The value of {option_name}" if option_name else "A word of the command"
            raise UsageError(f"{what} is empty. Give a value, or leave it out.")


def refuse_standard_output(arguments: Sequence[str]) -> None:
    """Refuse ``-`` as the name of an output, which other programs take for standard output.

    Raises:
        UsageError: the value of an output option is ``-``.
    """
    for option, value in [*pairwise(arguments), *(word.split("=", 1) for word in arguments if "=" in word)]:
        if option in _OUTPUT_OPTIONS and value == "-":
            raise UsageError(
                f"{option} cannot write to standard output. Name a file or folder; for the name -, say ./-."
            )


def _report_failure(message: str, code: int) -> int:
    if os.environ.get("TSR_TRACEBACK") and sys.exc_info()[0] is not None:
        import traceback

        traceback.print_exc()
    say(message)
    return code


def _usage_error(error: Any) -> int:  # Any: typer's parser is private
    """A usage error of the parser as one line."""
    context = getattr(error, "ctx", None)
    if type(error).__name__ == "NoArgsIsHelpError":  # `tsr` or `tsr train` alone
        typer.echo(context.get_help() if context is not None else error.format_message(), err=True)
        return EXIT_USAGE
    message = " ".join(error.format_message().split()).rstrip(".")
    path = context.command_path if context is not None else "tsr"
    unknown = context is not None and context.parent is None and message.startswith("No such command")
    is_review_command = unknown and not any(known.name == "review" for known in app.registered_commands)
    more = " `tsr` and `python -m app` also have the commands of the review tool." if is_review_command else ""
    say(f"{message}{'' if message.endswith('?') else '.'} See `{path} --help`.{more}")
    return EXIT_USAGE


def _explain(error: Exception) -> tuple[str, int]:
    """The sentence and exit code of an exception that is none of ours."""
    if isinstance(error, OSError) and error.errno in _PATH_ERRNOS and error.filename is not None:
        path = os.fsdecode(error.filename)
        return f"Cannot use {path}: {error.strerror}. Check the path and its permissions.", InputError.exit_code
    if isinstance(error, RuntimeError) and "no locator available" in str(error):  # Numba compiles only what it caches
        return (
            "Compiled code can be kept neither beside the installation nor in a cache folder, because both cannot be "
            "written. Set NUMBA_CACHE_DIR to a folder that can.",
            StorageError.exit_code,
        )
    text = str(error).strip().splitlines()
    first = f": {text[0]}" if text else ""
    return (
        f"Unexpected failure ({type(error).__name__}{first}). Set TSR_TRACEBACK=1 to see where it happened, "
        "and report it with that output.",
        EXIT_UNEXPECTED,
    )


def main() -> None:
    """Entry point of `python -m tsr_engine`."""
    sys.exit(run())
