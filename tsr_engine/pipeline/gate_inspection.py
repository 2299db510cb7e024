"""Recomputes one verdict of the gate from stored evidence, with all its factors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tsr_engine.errors import EvidenceError
from tsr_engine.evidence.columns import read_columns
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.gating.gate import Gate
from tsr_engine.gating.perceptual_hash import HashMemory, hash_picture, perceptual_hash
from tsr_engine.gating.symmetry import Symmetry
from tsr_engine.geometry.boxes import to_cxcywh
from tsr_engine.params import Params
from tsr_engine.pipeline.core import is_usable_box, shows_sign
from tsr_engine.protocols import PixelSource
from tsr_engine.recognition.crops import cut_pixels
from tsr_engine.records import GateVerdict, Picture


@dataclass(frozen=True, slots=True)
class Inspection:
    """The gate's inputs and factors for one prediction.

    Attributes:
        verdict: the recomputed verdict; equals the stored one if the pixels are those of the run.
        crop: the judged crop, BGR, with its margin.
        border: columns and rows of margin on each side of the crop.
        symmetry: the mirror axis, in px of the crop without its margin.
        memory: the mean of the track's earlier crops at the time of the verdict.
        crop_hash: the crop's 64 bits, first bit highest.
        mean_hash: the memory's 64 bits.
    """

    verdict: GateVerdict
    crop: Picture
    border: tuple[int, int]
    symmetry: Symmetry
    memory: HashMemory
    crop_hash: int
    mean_hash: int


def inspect_gate(
    reader: EvidenceReader, params: Params, track_id: int, frame: int, pixels: Callable[[int], PixelSource]
) -> Inspection | None:
    """Judge one stored prediction again.

    The memory of crops is rebuilt from the track's first frame, so that it equals that of the run.

    ``params`` are the run's own; ``pixels`` returns those of a frame by its ordinal.

    Returns:
        The inspection; None if the gate did not judge the track in that frame.

    Raises:
        EvidenceError: the evidence lacks a frame that is needed.
    """
    gate = Gate(params.gate)
    memory, previous = HashMemory.empty(), None
    size, shift = _size_and_shift(reader, frame)
    for ordinal, track in reader.track(track_id):
        if ordinal > frame:
            return None
        if ordinal == frame:
            if track.gate is None or track.prediction is None or previous is None or not memory.count:
                return None
            crop = cut_pixels(pixels(frame), track.prediction.box, gate.margin)
            centre, before = to_cxcywh(track.prediction.box), to_cxcywh(previous)
            return Inspection(
                verdict=gate.judge(crop, memory, centre[:2], before[:2], float(centre[2:].mean()), shift),
                crop=crop,
                border=gate.border(crop),
                symmetry=gate.symmetry(crop),
                memory=memory,
                crop_hash=perceptual_hash(hash_picture(crop)),
                mean_hash=perceptual_hash(memory.mean),
            )
        previous = track.box
        if is_usable_box(track.box, *size) and shows_sign(track.source, track.gate):
            memory = gate.remember(memory, cut_pixels(pixels(ordinal), track.box, gate.margin))
    return None


def _size_and_shift(reader: EvidenceReader, frame: int) -> tuple[tuple[int, int], tuple[float, float]]:
    """Width and height of a frame, px, and the camera's shift before it, px."""
    rows = read_columns(reader, "frames", "width", "height", "shift_x", "shift_y", frames=(frame, frame + 1))
    if not len(rows):
        raise EvidenceError(f"{reader.folder} holds no frame {frame}. Choose one of the run's own frames.")
    (width,), (height,) = rows.ints("width").tolist(), rows.ints("height").tolist()
    (x,), (y,) = rows.floats("shift_x").tolist(), rows.floats("shift_y").tolist()
    return (width, height), (x, y)
