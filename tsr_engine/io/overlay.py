"""Draws the annotated frame: the boxes of every stage over the picture, each with its own line style.

Detections are thin and pale, Kalman predictions dashed, search regions of relocalisations dotted, and results thick
boxes coloured by their source. The colours are Okabe and Ito's, which colour-blind people can distinguish.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from tsr_engine.io.drawing import Canvas, Colour, Rectangle
from tsr_engine.plural import plural
from tsr_engine.records import FrameEvidence, Picture, Source, TrackFrame

SOURCE_COLOURS: dict[Source, Colour] = {
    "detected": (115, 158, 0),
    "predicted": (0, 159, 230),
    "relocalised": (233, 180, 86),
}
DETECTION_COLOUR: Colour = (235, 235, 235)
PREDICTION_COLOUR: Colour = (200, 140, 235)
_FAINT: Colour = (190, 190, 190)
_WHITE: Colour = (255, 255, 255)
_REFERENCE_HEIGHT = 720
_READABLE_SIDE = 40  # a sign at least this large, in px at 720 px, needs no enlarged picture in its label


def draw(
    picture: Picture, evidence: FrameEvidence, class_names: Mapping[int, str] | Sequence[str], *, legend: bool = True
) -> Picture:
    """The frame with everything the engine decided about it drawn on top.

    Args:
        picture: the frame, BGR uint8; stays as it is.
        evidence: what the engine decided about this frame.
        class_names: class number -> name; a number without a name is shown as ``class 17``.
        legend: whether to explain the line styles in the lower left corner.

    Returns:
        A new picture of the same size.

    Raises:
        ValueError: the picture is not of the evidence's size.
    """
    if picture.shape != (evidence.height, evidence.width, 3):
        raise ValueError(
            f"Expected a picture of shape {(evidence.height, evidence.width, 3)}. Got {picture.shape} instead."
        )
    canvas = Canvas(picture.copy(), max(0.6, evidence.height / _REFERENCE_HEIGHT))
    used_detections = {track.detection for track in evidence.tracks}
    for row, box in enumerate(evidence.detections.boxes):
        canvas.draw_box(box, DETECTION_COLOUR, 1)
        if row not in used_detections:
            canvas.draw_note(box, f"{evidence.detections.scores[row]:.1f}", DETECTION_COLOUR)
            canvas.reserve([_rectangle(box)])
    for track in evidence.tracks:
        _draw_result(canvas, track)
    for track in evidence.tracks:
        _draw_intermediate_boxes(canvas, track)
    canvas.reserve([_rectangle(track.box) for track in evidence.tracks])
    # The nearest sign, which matters most, chooses its place first.
    for track in sorted(evidence.tracks, key=lambda track: -track.box[3] + track.box[1]):
        if track.state == "confirmed":
            is_small = np.max(track.box[2:] - track.box[:2]) < canvas.px(_READABLE_SIDE)
            thumbnail = _crop_sign(picture, track.box) if is_small else None
            canvas.draw_label(track.box, _label(track, class_names), SOURCE_COLOURS[track.source], thumbnail)
    _draw_header(canvas, evidence)
    if legend:
        _draw_legend(canvas)
    return canvas.picture


def _crop_sign(picture: Picture, box: np.ndarray) -> Picture:
    """The square around a box with a little margin, cut off at the frame; empty beyond it."""
    height, width = picture.shape[:2]
    centre, half = (box[:2] + box[2:]) / 2, 0.58 * float(np.max(box[2:] - box[:2]))
    x1, y1 = np.maximum(np.floor(centre - half), 0).astype(int)
    x2, y2 = np.minimum(np.ceil(centre + half), (width, height)).astype(int)
    return picture[y1:y2, x1:x2]


def _rectangle(box: np.ndarray) -> Rectangle:
    x1, y1, x2, y2 = (float(value) for value in box)
    return x1, y1, x2, y2


def _draw_result(canvas: Canvas, track: TrackFrame) -> None:
    """The result around the sign, not over it: a thick line would hide a small sign's face."""
    if track.state != "confirmed":
        canvas.draw_box(track.box, SOURCE_COLOURS[track.source], 1)
        return
    weight = 3 if min(track.box[2:] - track.box[:2]) >= canvas.px(32) else 2
    margin = canvas.px(weight) / 2 + 1
    canvas.draw_box(track.box + np.array([-margin, -margin, margin, margin]), SOURCE_COLOURS[track.source], weight)


def _draw_intermediate_boxes(canvas: Canvas, track: TrackFrame) -> None:
    if track.relocalisation is not None:
        canvas.draw_dashed_box(track.relocalisation.search_box, SOURCE_COLOURS["relocalised"], dash=2, gap=5)
        canvas.draw_box(track.relocalisation.box, SOURCE_COLOURS["relocalised"], 1)
    if track.prediction is not None:
        canvas.draw_dashed_box(track.prediction.box, PREDICTION_COLOUR, dash=6, gap=4)


def _label(track: TrackFrame, class_names: Mapping[int, str] | Sequence[str]) -> tuple[str, str]:
    """A headline with track and class, and a line of figures."""
    figures = []
    headline = f"#{track.track_id}"
    if track.recognition is not None:
        headline += f"  {_class_name(track.recognition.class_id, class_names)}"
        figures.append(f"{100 * track.recognition.share:.0f} % of votes")
    if track.gate is not None:
        figures.append(f"L+ {track.gate.l_positive:.3g} {'pass' if track.gate.confident else 'reject'}")
    figures.append(track.source)
    return headline, "   ".join(figures)


def _class_name(class_id: int, class_names: Mapping[int, str] | Sequence[str]) -> str:
    try:
        return class_names[class_id]
    except (KeyError, IndexError):
        return f"class {class_id}"


def _draw_header(canvas: Canvas, evidence: FrameEvidence) -> None:
    minutes, seconds = divmod(evidence.seconds, 60)
    signs = sum(track.state == "confirmed" for track in evidence.tracks)
    text = f"frame {evidence.ordinal}   {int(minutes):02d}:{seconds:06.3f}   {plural(signs, 'sign')}"
    size = canvas.text_size(text, 13)
    margin, pad = canvas.px(10), canvas.px(7)
    canvas.draw_panel((margin, margin, margin + size[0] + 2 * pad, margin + size[1] + 2 * pad))
    canvas.draw_text(text, (margin + pad, margin + pad + size[1]), 13, _WHITE)


def _draw_legend(canvas: Canvas) -> None:
    entries: list[tuple[str, Colour, str]] = [
        ("detection", DETECTION_COLOUR, "thin"),
        ("Kalman prediction", PREDICTION_COLOUR, "dashed"),
        ("search region", SOURCE_COLOURS["relocalised"], "dotted"),
        *((f"result: {source}", colour, "thick") for source, colour in SOURCE_COLOURS.items()),
    ]
    height, width = canvas.picture.shape[:2]
    row, pad, swatch, margin = canvas.px(19), canvas.px(8), canvas.px(24), canvas.px(10)
    inner = swatch + canvas.px(9) + max(canvas.text_size(name, 12)[0] for name, *_ in entries)
    left, top = margin, height - margin - len(entries) * row - 2 * pad + canvas.px(4)
    if top < height // 3 or inner + 2 * pad > width // 2:
        return  # a small picture has no room for it
    canvas.draw_panel((left, top, left + inner + 2 * pad, height - margin))
    for index, (name, colour, style) in enumerate(entries):
        middle = top + pad + index * row + row // 2 - canvas.px(2)
        ends = (left + pad, middle, left + pad + swatch, middle)
        match style:
            case "dashed":
                canvas.draw_dashed_line(ends, colour, 6, 4)
            case "dotted":
                canvas.draw_dashed_line(ends, colour, 2, 5)
            case _:
                thickness = canvas.px(3) if style == "thick" else 1
                cv2.line(canvas.picture, ends[:2], ends[2:], colour, thickness, cv2.LINE_AA)
        canvas.draw_text(name, (left + pad + swatch + canvas.px(9), middle + canvas.px(4)), 12, _FAINT)
