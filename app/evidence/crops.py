"""Crops of a track, from the pixels in evidence or else from the video."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import cv2
import numpy as np

from tsr_engine.errors import EvidenceError
from tsr_engine.evidence.columns import BOX, frame_size, read_columns
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.evidence.regions import FramePixels, StoredPixels
from tsr_engine.recognition.crops import crop_bounds
from tsr_engine.records import FloatArray, Picture

MARGIN = 0.1
"""Border around a result, as a share of its side; the default of classifier and gate."""

CropOf = Literal["result", "prediction"]


def box_in_frame(reader: EvidenceReader, track_id: int, frame: int, of: CropOf) -> FloatArray | None:
    """Return the box of a track in a frame; None: it has none."""
    table = "track_frames" if of == "result" else "predictions"
    rows = read_columns(reader, table, *BOX, frames=(frame, frame + 1), tracks=(track_id, track_id))
    boxes = rows.boxes()
    return boxes[0] if len(rows) and np.isfinite(boxes[0]).all() else None


def pixels_in_frame(reader: EvidenceReader, frame: int) -> StoredPixels | None:
    """Return the stored pixels of a frame; None: there are none."""
    size = frame_size(reader, frame)
    regions = reader.regions(frame)
    return StoredPixels(*size, regions) if size and regions else None


def crop_of(stored: StoredPixels | None, box: FloatArray, margin: float, picture: Callable[[], Picture]) -> Picture:
    """Crop a box with its margin.

    Args:
        stored: stored pixels of the frame.
        box: shape (4,).
        margin: border on each side, share of the box's side.
        picture: decodes the whole frame; called only if the stored pixels do not cover the crop.
    """
    bounds = crop_bounds(box, margin)
    if stored is not None:
        before = stored.missing
        crop = stored.crop(*bounds)
        if stored.missing == before:
            return crop
    return FramePixels(picture()).crop(*bounds)


def encode(crop: Picture, size: int) -> bytes:
    """Encode a crop as PNG whose longer side has ``size`` px.

    Raises:
        EvidenceError: the crop has no pixels.
    """
    height, width = crop.shape[:2]
    if not height or not width:
        raise EvidenceError("The crop has no pixels: its box has no area.")
    scale = size / max(height, width)
    target = max(1, round(width * scale)), max(1, round(height * scale))
    interpolation = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    _, code = cv2.imencode(
        ".png", cv2.resize(crop, target, interpolation=interpolation), [cv2.IMWRITE_PNG_COMPRESSION, 3]
    )
    return code.tobytes()
