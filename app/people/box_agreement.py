"""Agreement of two people's boxes, in frames where both have drawn one."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from app.body_model import Model
from app.edits.history import undone_operations
from app.labels.store import newest
from app.people.agreement_statistics import by_name, label_name, mean_interval
from app.storage.lookup import in_parts
from app.storage.models import Edit, SearchTrack
from tsr_engine.geometry.boxes import iou_each
from tsr_engine.labels.model import LabelSet

Box = tuple[float, float, float, float]


class BoxAgreement(Model):
    """Overlap of boxes of two people."""

    name: str
    tracks: int
    frames: int
    """Number of frames in which two people have drawn a box of such a track."""
    iou: float
    """Mean over the tracks of the mean IoU over a track's frames; in [0, 1]."""
    low: float
    """Lower end of the 95 % interval of that mean."""
    high: float


class BoxAgreements(Model):
    """Overlap in the whole library and its parts."""

    whole: BoxAgreement
    labels: list[BoxAgreement]
    first: list[BoxAgreement]
    """By the person who drew the first box."""
    second: list[BoxAgreement]
    """By the person who drew the second box."""


@dataclass(frozen=True, slots=True)
class Drawn:
    """A frame of a track with boxes of two people."""

    run: str
    track: str
    first: str
    second: str
    iou: float


def drawn_twice(rows: Iterable[tuple[str, str, str, int, Box]]) -> list[Drawn]:
    """Find frames in which a person has drawn a box again that another person had drawn.

    If a person draws a box several times in a row, the last one counts.

    Args:
        rows: author, run, track, frame and box of each operation that draws one, in the order of the log.
    """
    boxes_by_frame: dict[tuple[str, str, int], list[tuple[str, Box]]] = defaultdict(list)
    for author, run, track, frame, box in rows:
        boxes = boxes_by_frame[run, track, frame]
        if boxes and boxes[-1][0] == author:
            boxes.pop()
        boxes.append((author, box))
    pairs = [(frame_key, a, b) for frame_key, boxes in boxes_by_frame.items() for a, b in pairwise(boxes)]
    overlaps = iou_each([a[1] for _, a, _ in pairs], [b[1] for _, _, b in pairs]) if pairs else np.empty(0)
    return [
        Drawn(run, track, first[0], second[0], float(overlap))
        for ((run, track, _), first, second), overlap in zip(pairs, overlaps, strict=True)
    ]


def box_agreements(session: Session) -> BoxAgreements:
    """Compute the overlap of boxes by label and by person; undone operations do not count."""
    drawn_frames = drawn_twice(_drawn(session))
    label_names = _labels(session, sorted({drawn.run for drawn in drawn_frames}))
    return BoxAgreements(
        whole=_agreement("all", drawn_frames),
        labels=_by_name((name, each) for each in drawn_frames if (name := label_names.get((each.run, each.track)))),
        first=_by_name((drawn.first, drawn) for drawn in drawn_frames),
        second=_by_name((drawn.second, drawn) for drawn in drawn_frames),
    )


def _drawn(session: Session) -> list[tuple[str, str, str, int, Box]]:
    reverting = select(Edit.kind, Edit.reverts).where(Edit.kind.in_(["undo", "redo"])).order_by(Edit.seq)
    undone = undone_operations((kind, reverts) for kind, reverts in session.execute(reverting))
    query = select(Edit.op_id, Edit.author, Edit.run_id, Edit.command)
    drawing = query.where(Edit.kind.in_(["create_track", "set_box"])).order_by(Edit.seq)
    return [
        (author, run, command["key"], command["frame"], tuple(command["box"]))
        for op_id, author, run, command in session.execute(drawing)
        if op_id not in undone
    ]


def _labels(session: Session, runs: Sequence[str]) -> dict[tuple[str, str], str]:
    """Run and track -> name of its current label; deleted tracks are left out."""
    sets: dict[str, LabelSet] = {}
    found: dict[tuple[str, str], str] = {}
    columns = SearchTrack.run_id, SearchTrack.key, SearchTrack.set_key, SearchTrack.label
    for part in in_parts(runs):
        query = select(*columns).where(SearchTrack.run_id.in_(part))
        for run, key, set_key, label in session.execute(query):
            if set_key not in sets:
                sets[set_key] = newest(session, set_key)
            found[run, key] = label_name(sets[set_key], label)
    return found


def _by_name(named: Iterable[tuple[str, Drawn]]) -> list[BoxAgreement]:
    return [_agreement(name, found) for name, found in by_name(named)]


def _agreement(name: str, drawn_frames: Sequence[Drawn]) -> BoxAgreement:
    tracks: dict[tuple[str, str], list[float]] = defaultdict(list)
    for drawn in drawn_frames:
        tracks[drawn.run, drawn.track].append(drawn.iou)
    mean, low, high = mean_interval([math.fsum(each) / len(each) for each in tracks.values()])
    iou, low, high = round(mean, 4), round(low, 4), round(high, 4)
    return BoxAgreement(name=name, tracks=len(tracks), frames=len(drawn_frames), iou=iou, low=low, high=high)
