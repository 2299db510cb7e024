"""``tsr import``: import a file of another tool for a video, without a server."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.cli.exchange_common import OptionOption, pairs, print_lines
from app.cli.library import HomeOption
from tsr_engine.cli.common import JsonOption, existing, out_console, print_json, say
from tsr_engine.errors import UsageError
from tsr_engine.plural import plural

_REMEDY = (
    "Map them to labels with --label NAME=KEY, or choose --unknown add|skip|refuse for the others "
    "(--add NAME adds a single one)."
)
_NOUN = {"annotation": "corrections of run", "truth": "ground truth", "run": "run"}


def import_file(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A file, ZIP archive or folder of another tool.")],
    onto: Annotated[
        str, typer.Option("--onto", metavar="VIDEO", help="The video: its file, its name in the library, or its id.")
    ],
    kind: Annotated[
        str, typer.Option("--as", metavar="annotation|truth|run", help="Import as corrections, ground truth or a run.")
    ],
    home: HomeOption = None,
    run: Annotated[
        str | None, typer.Option("--run", metavar="RUN", help="The run to correct; unset: the video's newest.")
    ] = None,
    format: Annotated[
        str | None, typer.Option("--format", metavar="NAME", help="See 'tsr formats'; unset: detected.")
    ] = None,
    name: Annotated[
        str | None, typer.Option("--name", help="Name of the ground truth or run; unset: the file's.")
    ] = None,
    labels: Annotated[
        list[str],
        typer.Option(
            "--label",
            metavar="NAME=LABEL",
            help="Label for a name in the file: its key or number, -1 for none; repeatable, and remembered.",
        ),
    ] = [],  # noqa: B006 - typer copies it
    unknown: Annotated[
        str,
        typer.Option(
            "--unknown",
            metavar="refuse|add|skip",
            help="Unknown names: refuse the file and list them, add them to the set, or leave them out.",
        ),
    ] = "refuse",
    added: Annotated[
        list[str],
        typer.Option("--add", metavar="NAME", help="A name to add to the set, regardless of --unknown; repeatable."),
    ] = [],  # noqa: B006 - typer copies it
    options: OptionOption = [],  # noqa: B006 - typer copies it
    author: Annotated[str | None, typer.Option("--author", help="Author of the corrections.")] = None,
    json: JsonOption = False,
) -> None:
    """Import a file of another tool for a video, completely or not at all.

    \b
    Examples:
      tsr import annotations.xml --onto drive.mp4 --as annotation
      tsr import gt.zip --onto drive.mp4 --as truth --format mot
      tsr import their_tracker.csv --onto drive.mp4 --as run --label Stopschild=stop --unknown add
    """
    from app.cli.data_folder import find_video, open_home
    from app.cli.run_names import as_command_error, find_sources
    from app.edits.bulk import BulkEdits
    from app.edits.log_store import LogStore
    from app.events import EventBus
    from app.evidence.service import EvidenceService
    from app.exchange.import_file import ImportFile
    from app.exchange.imports import ImportService
    from app.ground_truths.service import GroundTruthService

    if kind not in ("annotation", "truth", "run"):
        raise UsageError(f"--as must be annotation, truth or run. Got '{kind}'.")
    if run is not None and kind != "annotation":
        raise UsageError("--run is for --as annotation: it names the run to correct. Leave it out.")
    if unknown not in ("refuse", "add", "skip"):
        raise UsageError(f"--unknown must be refuse, add or skip. Got '{unknown}'.")
    incoming = ImportFile(
        path=existing(file, "file"),
        name=name or file.name,
        format=format,
        switches=pairs("--option", options),
        label_map={text: _word(value) for text, value in pairs("--label", labels).items()},
        unknown=unknown,  # type: ignore[arg-type]
        added=frozenset(added),
        remedy=_REMEDY,
        author=author or "",
    )
    with as_command_error(), open_home(home) as (settings, database):
        events = EventBus()
        evidence = EvidenceService(settings, database)
        edits = BulkEdits(LogStore(database, events, evidence, settings))
        imports = ImportService(settings, database, events, edits, GroundTruthService(database))
        with database.read() as session:
            video = find_video(session, onto)
        run_id = None
        if kind == "annotation":
            run_id = find_sources([run or video.id], settings.home, None, say)[0].run_id
        try:
            result = imports.import_file(video.id, incoming, kind, run_id)  # type: ignore[arg-type]
        finally:
            evidence.close()
    if json:
        print_json(result.model_dump(mode="json"))
        return
    console = out_console()
    same = f"; {plural(result.same, 'track')} {'was' if result.same == 1 else 'were'} unchanged" if result.same else ""
    brought = f"{plural(result.tracks, 'track')} with {plural(result.boxes, 'box', 'boxes')}"
    console.print(f"{brought} became {_NOUN[kind]} {result.id}{same}.", soft_wrap=True)
    print_lines([f"Changed: {sentence}" for sentence in result.repaired])
    print_lines([f"Skipped: {item.what}. {item.reason}" for item in result.skipped])


def _word(text: str) -> int | str:
    """Parse a label as people write it: its number, or its key."""
    try:
        return int(text)
    except ValueError:
        return text
