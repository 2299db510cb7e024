"""Every computation between pixels and records, on frames of the sample drive.

As a script it prints their digests with one BLAS thread and with two.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from threadpoolctl import threadpool_limits

from sample_videos import SHIPPED
from tsr_engine.channels.compute import compute_channels
from tsr_engine.detection.acf import AcfDetector
from tsr_engine.detection.prior import parzen, with_prior
from tsr_engine.detection.refine.box_inset import BoxInset
from tsr_engine.evidence.regions import FramePixels
from tsr_engine.gating.gate import Gate
from tsr_engine.gating.perceptual_hash import HashMemory
from tsr_engine.gating.symmetry import SymmetryDetector
from tsr_engine.geometry.boxes import to_cxcywh
from tsr_engine.io.video import open_video
from tsr_engine.online.incremental_svm import IncrementalSVC
from tsr_engine.params import Params
from tsr_engine.params.tracking import TrackingParams
from tsr_engine.pipeline import Components, load_components, load_reader
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.recognition.crops import cut
from tsr_engine.recognition.fusion import Fusion
from tsr_engine.recognition.mixture import Mixture
from tsr_engine.records import FloatArray, Picture
from tsr_engine.tracking.camera_shift import CameraShift
from tsr_engine.tracking.motion import make_motion

__all__ = ["PIECES", "digests", "moved"]

PARAMS = Params()
BOX = np.array([818.85, 25.24, 929.57, 131.93])
"""The sign of track 1 in frame 62 of the sample drive."""


@lru_cache
def pictures() -> tuple[Picture, Picture]:
    """Frames 61 and 62 of the sample drive."""
    with open_video(SHIPPED[0].video) as video:
        before, now = (frame.picture for frame in video.frames(61, 63))
    return before, now


@lru_cache
def shipped() -> Components:
    """The shipped models."""
    return load_components(PARAMS)


def moved(value: Any, by: int) -> Any:
    """A copy in which every array begins ``by`` bytes (times its item size) after a multiple of 64."""
    if isinstance(value, np.ndarray):
        room = np.empty(value.nbytes + 64 + by * value.itemsize, np.uint8)
        first = -room.ctypes.data % 64 + by * value.itemsize
        place = room[first : first + value.nbytes].view(value.dtype).reshape(value.shape)
        place[...] = value
        return place
    if type(value) is tuple:
        return tuple(moved(item, by) for item in value)
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{item.name: moved(getattr(value, item.name), by) for item in fields(value)})
    return value


def gate(by: int) -> Iterator[Any]:
    before, now = (moved(picture, by) for picture in pictures())
    judge = Gate(PARAMS.gate)
    memory = judge.remember(HashMemory.empty(), cut(before, BOX - 3.0, judge.margin))
    crop = moved(cut(now, BOX, judge.margin), by)
    centre = to_cxcywh(BOX)
    yield judge.judge(crop, moved(memory, by), centre[:2], centre[:2] - 3.0)
    yield judge.symmetry(crop)
    busy = cv2.GaussianBlur(np.random.default_rng(1).integers(0, 256, (96, 96), dtype=np.uint8), (0, 0), 1.0)
    found = SymmetryDetector(size=96).measure(moved(busy, by))
    assert found.features > 64, "with fewer no BLAS uses a second thread"
    yield found


def shift(by: int) -> Iterator[Any]:
    camera = CameraShift()
    for picture in pictures():
        yield camera.step(moved(picture, by))


def channels(by: int) -> Iterator[Any]:
    for shrink in (1, 2, 4):
        yield compute_channels(moved(pictures()[1][:202, :303].copy(), by), shrink)


def detector(by: int) -> Iterator[Any]:
    detects = shipped().detector
    assert isinstance(detects, AcfDetector)
    model = moved(detects.model, by)
    one = AcfDetector(model, moved(detects.prior, by), PARAMS.detector, PARAMS.prior)
    picture = moved(pictures()[1][:360, 560:1040].copy(), by)
    found = one.detect(picture)
    assert len(found.boxes)
    yield found
    boxes, scores = one.candidates(picture)
    assert len(boxes)
    yield boxes
    yield model.refine(picture, moved(boxes, by), scores)
    yield BoxInset.of(PARAMS.detector).undo(boxes)
    yield with_prior(scores, one.prior.at(boxes, 480, 360) if one.prior is not None else scores, 1.7)
    yield parzen(moved(to_cxcywh(boxes)[:, :2] / 480.0, by), 0.05)


def rescore_windows(by: int) -> Iterator[Any]:
    look = shipped().parts.window_scorer
    assert look is not None
    seen = moved(look, by)(FramePixels(moved(pictures()[1], by)), moved(BOX + 4.0, by))
    assert seen is not None
    yield seen


def classifier(by: int) -> Iterator[Any]:
    machine = shipped().parts.classifier
    assert isinstance(machine, Mixture)
    crops = [moved(cut(picture, BOX - d, machine.margin), by) for picture in pictures() for d in (0.0, 5.0)]
    fusion = Fusion.start(PARAMS.fusion)
    for row in moved(machine, by).probabilities(crops):
        fusion, record = fusion.update(moved(row, by), 60.0)
        yield record


def network(by: int) -> Iterator[Any]:
    machine = load_reader(reader="network")
    assert isinstance(machine, SignClassifier)
    crops = [moved(cut(picture, BOX - d, machine.margin), by) for picture in pictures() for d in (0.0, 5.0)]
    yield moved(machine, by).margins(crops)


def online(by: int) -> Iterator[Any]:
    make = shipped().parts.make_online
    assert make is not None
    before, now = (FramePixels(moved(picture, by)) for picture in pictures())
    machine, _ = make(before, BOX - 3.0, 61)
    machine.learn(now, moved(BOX, by), 1, 62)
    yield machine.relocalise(now, moved(BOX + 6.0, by))
    rng = np.random.default_rng(3)
    samples, labels = rng.normal(size=(60, 7)), np.where(rng.random(60) < 0.5, 1, -1)
    for svm in (IncrementalSVC(0.5), IncrementalSVC(5.0, "rbf", 0.3)):
        svm.partial_fit(moved(samples, by), labels).unlearn([3, 8, 21])
        yield svm.alpha_, svm.intercept_, svm.decision_function(moved(samples[:9], by)), svm.dual_objective_


def motion(by: int) -> Iterator[Any]:
    for name in ("paper", "constant_velocity", "looming"):
        model = make_motion(TrackingParams(motion=name))
        state = model.initiate(np.array([400.0, 200.0, 30.0, 31.0]), 1280, 720)
        for k in range(1, 12):
            state = moved(model.predict(state, 1.0, (0.3, -0.2)), by)
            box: FloatArray = np.array([400.0 + 3.3 * k, 200.0 - 1.7 * k, 30.0 + k, 31.0 + k])
            state = moved(model.update(state, moved(box, by)), by)
            yield state, model.innovation(state)


PIECES: dict[str, Callable[[int], Iterator[Any]]] = {
    piece.__name__: piece
    for piece in (gate, shift, channels, detector, rescore_windows, classifier, network, online, motion)
}


def digests(by: int, threads: int) -> dict[str, str]:
    """Digests of every computation's result, to the last bit.

    Args:
        by: offset of its arrays, see :func:`moved`.
        threads: of BLAS and of OpenCV.
    """
    before = cv2.getNumThreads()
    cv2.setNumThreads(threads)
    try:
        with threadpool_limits(limits=threads, user_api="blas"):
            return {name: hashlib.sha256(_bytes(tuple(piece(by)))).hexdigest() for name, piece in PIECES.items()}
    finally:
        cv2.setNumThreads(before)


def _bytes(value: Any) -> bytes:
    if is_dataclass(value) and not isinstance(value, type):
        return b"".join(_bytes(getattr(value, item.name)) for item in fields(value))
    if isinstance(value, tuple):
        return b"".join(map(_bytes, value))
    return np.asarray(value).tobytes()


if __name__ == "__main__":
    print(json.dumps([digests(0, threads) for threads in (1, 2)]))
