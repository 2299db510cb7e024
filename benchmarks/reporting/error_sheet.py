"""Pictures of errors on clips whose pictures may be shown: signs missed or misread, tracks on no sign."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.reporting.contact_sheet import Cell, write_sheet
from benchmarks.videos.stored_detections import AnnotatedVideo, DetectedVideo, detect_videos, pictures
from benchmarks.videos.tracked_clips import Videos, track_together
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params import Params
from tsr_engine.pipeline import Components, load_components
from tsr_engine.records import FloatArray
from tsr_engine.track_table import TrackTable

MAX_PICTURES = 24
LABELS = {"missed": "N", "misread": "M", "false": "F"}
"""First letter of a label by kind, in the order of the sheet."""


def draw_error_sheet(sheet: Path, scratch: Path, videos: Videos, notes: Mapping[str, Sequence[JsonObject]]) -> None:
    """Draw a sheet of the signs and tracks in ``notes``, each in the frame in which it is largest.

    Args:
        sheet: PNG to write; removed if there is nothing to show.
        scratch: folder with the evidence of earlier runs.
        videos: name -> (file, ground truth).
        notes: result of ``sign_notes``; drawn notes get a ``label``.
    """
    sheet.unlink(missing_ok=True)
    wanted = [(kind, note) for kind in LABELS for note in notes[kind]][:MAX_PICTURES]
    params = Params.preset("default")
    components = load_components(params)
    for number, (kind, note) in enumerate(wanted, 1):
        note["label"] = f"{LABELS[kind]}{number}"
    cells: dict[str, Cell] = {}
    for name in sorted({note["clip"] for _, note in wanted}):
        video, truth = videos[name]
        here = [(kind, note) for kind, note in wanted if note["clip"] == name]
        seen = next(detect_videos([AnnotatedVideo(name, "", video, truth)], scratch / "detections", components))
        boxes = {note["label"]: _boxes(kind, note, seen, truth, components, params) for kind, note in here}
        places = {label: largest(found) for label, found in boxes.items() if found}
        for frame, picture in pictures(seen):
            for label, (ordinal, box) in places.items():
                if frame.ordinal == ordinal:
                    cells[label] = Cell(label, picture, box)
    write_sheet(sheet, [cells[note["label"]] for _, note in wanted if note["label"] in cells], columns=8)


def largest(boxes: Mapping[int, FloatArray]) -> tuple[int, FloatArray]:
    """Frame and box of the largest box."""
    frame = max(boxes, key=lambda k: float((boxes[k][2] - boxes[k][0]) * (boxes[k][3] - boxes[k][1])))
    return frame, boxes[frame]


def _boxes(
    kind: str, note: JsonMapping, seen: DetectedVideo, truth: TrackTable, components: Components, params: Params
) -> dict[int, FloatArray]:
    """Frame -> annotated box of a sign, or box of a track."""
    if kind != "false":
        own = np.flatnonzero(truth.track == note["sign"])
        whole = own[truth.visibility[own] >= 0.99]
        own = whole if len(whole) else own
        return {int(truth.frame[i]): truth.boxes[i] for i in own}
    rows = track_together(seen, {"default": params}, {"default": components})["default"].rows
    return {r.frame: np.array([r.x1, r.y1, r.x2, r.y2]) for r in rows if r.track_id == note["track"]}
