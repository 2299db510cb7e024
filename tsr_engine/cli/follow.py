"""`tsr follow`: a sign that is drawn once, in all frames of a video that show it."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

import json as json_module
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tsr_engine.cli.common import ModelsOption, existing, say
from tsr_engine.errors import UsageError
from tsr_engine.io.video_kinds import KIND_NAMES
from tsr_engine.json_shapes import JsonMapping
from tsr_engine.plural import plural

if TYPE_CHECKING:
    from tsr_engine.follow import Anchor, Direction, Ending, Proposal

COLUMNS = "frame,x1,y1,x2,y2,confidence,source"


def follow(
    video: Annotated[Path, typer.Argument(metavar="VIDEO", help=f"A video file: {KIND_NAMES}.")],
    boxes: Annotated[
        list[str],
        typer.Option(
            "--box",
            metavar="FRAME,x1,y1,x2,y2",
            help="A box of the sign: frame from 0, pixel edges. Repeat it for other frames of the same sign.",
        ),
    ],
    only: Annotated[
        str | None,
        typer.Option("--only", metavar="forward|backward", help="Follow in one direction only; unset: both."),
    ] = None,
    csv: Annotated[Path | None, typer.Option("--csv", metavar="OUT", help="Write the rows there.")] = None,
    models: ModelsOption = None,
    json: Annotated[
        bool, typer.Option("--json", help="Print one JSON object for each row, for another program.")
    ] = False,
) -> None:
    """Follow a sign from a box that you draw, until it is gone.

    The rows are frame,x1,y1,x2,y2,confidence,source in the order of the frames: pixel edges, the probability that the
    box lies on the sign, and the source: anchor (yours), detected, matched or predicted (the sign is hidden). Without
    --csv they are printed. For each direction the command says where and why it ended. With --json each line is an
    object with these names, or one with direction, frame, reason and sentence.

    \b
    Examples:
      tsr follow drive.mp4 --box 120,604.5,310,640,346
      tsr follow drive.mp4 --box 120,604.5,310,640,346 --box 160,702,250,790,339 --csv sign.csv
      tsr follow drive.mp4 --box 120,604.5,310,640,346 --only backward --json
    """
    anchors = [read_box(text) for text in boxes]
    direction = read_direction(only)
    from tsr_engine.cli.interrupt import leave_interrupted, stop_on_interrupt
    from tsr_engine.cli.progress import progress_bar
    from tsr_engine.follow import Ending
    from tsr_engine.follow_video import follow_video, load_follower
    from tsr_engine.io.atomic import atomic_text, refuse_inputs

    refuse_inputs([csv], [existing(video, "video")])
    parts = load_follower(models)
    rows: dict[int, Proposal] = {}
    endings: list[Ending] = []
    with stop_on_interrupt() as stopped, progress_bar("following", "frames") as show:
        for event in follow_video(video, anchors, parts, direction=direction, cancelled=stopped):
            if isinstance(event, Ending):
                endings.append(event)
                drop_rows_beyond(rows, event)
            else:
                rows[event.frame] = event
                show(len(rows), None, "")
    ordered = [rows[frame] for frame in sorted(rows)]
    if csv is not None:
        with atomic_text(csv) as out:
            out.writelines(f"{line}\n" for line in table_lines(ordered))
    if json:
        for value in (*map(as_json, ordered), *map(ending_as_json, endings)):
            typer.echo(json_module.dumps(value, allow_nan=False))
    elif csv is not None:
        reasons = " ".join(ending.sentence for ending in endings)
        span = f"{ordered[0].frame} to {ordered[-1].frame}"
        typer.echo(f"{csv}: {plural(len(ordered), 'frame')}, {span}. {reasons}")
    else:
        for line in table_lines(ordered):
            typer.echo(line)
        sys.stdout.flush()
        for ending in endings:
            say(ending.sentence)
    if stopped():
        leave_interrupted(f"The frames followed so far are {f'in {csv}' if csv is not None else 'shown above'}.")


def read_box(text: str) -> Anchor:
    """Parse ``FRAME,x1,y1,x2,y2`` as an anchor; following checks the box itself.

    Raises:
        UsageError: the text has another form.
    """
    import numpy as np

    from tsr_engine.follow import Anchor

    parts = text.split(",")
    try:
        frame, edges = int(parts[0]), [float(part) for part in parts[1:]]
    except ValueError:
        edges = []
    if len(edges) != 4:
        raise UsageError(
            f"--box expects FRAME,x1,y1,x2,y2: a whole number and four edges in px, for example "
            f"120,604.5,310,640,346. Got '{text}' instead."
        )
    return Anchor(frame, np.array(edges))


def read_direction(text: str | None) -> Direction | None:
    """The direction given by --only; None: both.

    Raises:
        UsageError: it is not a direction.
    """
    if text is None or text == "forward" or text == "backward":
        return text  # type: ignore[return-value]
    raise UsageError(f"--only expects forward or backward. Got '{text}' instead.")


def drop_rows_beyond(rows: dict[int, Proposal], ending: Ending) -> None:
    """Remove proposals beyond the frame in which a direction ended."""
    for frame in list(rows):
        if (frame > ending.frame) if ending.direction == "forward" else (frame < ending.frame):
            del rows[frame]


def table_lines(rows: Iterable[Proposal]) -> Iterator[str]:
    """The lines of the table, starting with its header."""
    yield COLUMNS
    for row in rows:
        edges = ",".join(f"{float(v):.2f}" for v in row.box)
        yield f"{row.frame},{edges},{row.confidence:.4f},{row.source}"


def as_json(row: Proposal) -> JsonMapping:
    """A proposal as JSON values."""
    edges = dict(zip(("x1", "y1", "x2", "y2"), (round(float(v), 2) for v in row.box), strict=True))
    return {"frame": row.frame, **edges, "confidence": round(row.confidence, 4), "source": row.source}


def ending_as_json(ending: Ending) -> JsonMapping:
    """An ending as JSON values."""
    return {"direction": ending.direction, "frame": ending.frame, "reason": ending.reason, "sentence": ending.sentence}
