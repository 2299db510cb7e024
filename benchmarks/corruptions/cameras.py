"""Scenes as other cameras would show them, changed in ways that training does not use."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Final

import av
import cv2
import numpy as np

from benchmarks.boxes import lies_elsewhere
from tsr_engine.detection.acf import AcfDetector
from tsr_engine.evaluation.detection import match
from tsr_engine.geometry.boxes import iou
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.pictures import read_picture
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.progress import Progress
from tsr_engine.training.synthetic.augment import shade

MIN_WIDTH_PX: Final = 16.0
"""Least longer side of a counted sign, px."""

_NARROW: Final = 0.72
"""Width of a scene with turned signs, as a share of the original width."""


def version(name: str, picture: Picture, scene: Scene, seed: int) -> tuple[Picture, FloatArray]:
    """A scene as another camera shows it.

    Args:
        name: name in ``VERSIONS``.
        picture: picture of the scene, BGR.
        scene: the scene with its signs.
        seed: random seed; the same scene and seed give the same version.

    Returns:
        The picture and the boxes of its signs (n, 4).
    """
    rng = np.random.default_rng([seed, int(scene.path.stem), list(VERSIONS).index(name)])
    if name == "turned away":
        size = (round(picture.shape[1] * _NARROW), picture.shape[0])
        narrow = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
        factor = size[0] / picture.shape[1]
        return np.asarray(narrow, np.uint8), scene.boxes * np.array([factor, 1.0, factor, 1.0])
    if name == "shadows":
        for box in scene.boxes:
            picture = shade(picture, box, rng)
        return picture, scene.boxes
    return VERSIONS[name](picture, rng), scene.boxes


def by_version(detector: AcfDetector, scenes: Sequence[Scene], seed: int, tick: Progress) -> dict[str, dict[str, int]]:
    """Count the results of a detector by version and stage.

    Args:
        detector: detector without box inset, so that its boxes are drawn as the annotation.
        scenes: scenes; their ignored signs do not count.
        seed: seed of the versions.
        tick: called after each picture.

    Returns:
        For each version the numbers of ``pictures`` and ``signs``; of signs with ``candidates`` of the cascade (IoU
        0.3); of signs ``found`` with log-odds above 0 (IoU 0.5); and of such detections on ``nothing``.
    """
    out = {name: {"pictures": 0, "signs": 0, "candidates": 0, "found": 0, "nothing": 0} for name in VERSIONS}
    for number, scene in enumerate(scenes):
        tick("versions of scenes", number, len(scenes))
        taken = read_picture(scene.path)
        for name, row in out.items():
            picture, truth = version(name, taken, scene, seed)
            ignored = scene.ignored * (picture.shape[1] / taken.shape[1], 1, picture.shape[1] / taken.shape[1], 1)
            counted = (truth[:, 2:] - truth[:, :2]).max(axis=1, initial=0.0) >= MIN_WIDTH_PX
            candidates, _ = detector.candidates(picture)
            seen = detector.detect(picture)
            boxes, scores = seen.boxes[seen.raw_scores > 0], seen.raw_scores[seen.raw_scores > 0]
            _, by = match(boxes, scores, truth)
            row["pictures"] += 1
            row["signs"] += int(counted.sum())
            row["candidates"] += int((iou(truth, candidates).max(axis=1, initial=0.0) >= 0.3)[counted].sum())
            row["found"] += int((np.array(by) >= 0)[counted].sum())
            row["nothing"] += int(lies_elsewhere(boxes, np.concatenate([truth, ignored])).sum())
    return out


def _as_taken(picture: Picture, rng: np.random.Generator) -> Picture:
    return picture


def _soft(picture: Picture, rng: np.random.Generator) -> Picture:
    return _jpeg(_through(picture, float(rng.uniform(0.5, 0.65)), cv2.INTER_LINEAR), int(rng.integers(40, 60)))


def _sharpened(picture: Picture, rng: np.random.Generator) -> Picture:
    return _jpeg(_levels(_unsharp(picture, 1.6, 1.2), contrast=1.25), int(rng.integers(45, 65)))


def _video(picture: Picture, rng: np.random.Generator) -> Picture:
    return _h264(picture, int(rng.integers(34, 39)))


def _screen_shot(picture: Picture, rng: np.random.Generator) -> Picture:
    height, width = picture.shape[:2]
    small = cv2.resize(picture, (int(width * 0.72) // 2 * 2, int(height * 0.72) // 2 * 2), interpolation=cv2.INTER_AREA)
    shown = cv2.resize(_h264(np.asarray(small, np.uint8), 31), (width, height), interpolation=cv2.INTER_CUBIC)
    return _jpeg(_unsharp(np.asarray(shown, np.uint8), 0.7, 1.0), int(rng.integers(55, 75)))


def _dim(picture: Picture, rng: np.random.Generator) -> Picture:
    dark = _levels(picture, gamma=1.5, gain=0.45, balance=(1.12, 1.0, 0.9))
    noisy = dark + rng.normal(0, 3.0, dark.shape)
    return _jpeg(np.clip(noisy, 0, 255).astype(np.uint8), 60)


def _hazy(picture: Picture, rng: np.random.Generator) -> Picture:
    return _jpeg(_levels(picture, contrast=0.55, lift=40.0, balance=(0.9, 1.0, 1.08)), int(rng.integers(40, 60)))


def _levels(
    picture: Picture,
    *,
    gamma: float = 1.0,
    gain: float = 1.0,
    contrast: float = 1.0,
    lift: float = 0.0,
    balance: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> Picture:
    value = 255 * (np.arange(256) / 255) ** gamma * gain
    value = (value - 110) * contrast + 110 + lift
    table = np.clip(value[:, None] * np.array(balance), 0, 255).astype(np.uint8)
    return np.asarray(cv2.LUT(picture, table[None]), np.uint8)


def _unsharp(picture: Picture, amount: float, radius: float) -> Picture:
    blurred = cv2.GaussianBlur(picture, (0, 0), radius)
    return np.asarray(cv2.addWeighted(picture, 1 + amount, blurred, -amount, 0), np.uint8)


def _through(picture: Picture, share: float, back: int) -> Picture:
    height, width = picture.shape[:2]
    small = cv2.resize(picture, (round(width * share), round(height * share)), interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.resize(small, (width, height), interpolation=back), np.uint8)


def _jpeg(picture: Picture, quality: int) -> Picture:
    _, code = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])
    return np.asarray(cv2.imdecode(code, cv2.IMREAD_COLOR), np.uint8)


def _h264(picture: Picture, quantiser: int) -> Picture:
    """The picture as a key frame of a video at a low bit rate."""
    frame = av.VideoFrame.from_ndarray(picture, format="bgr24").reformat(format="yuv420p")
    encoder = av.CodecContext.create("libx264", "w")
    encoder.width, encoder.height, encoder.pix_fmt = frame.width, frame.height, "yuv420p"
    encoder.time_base = Fraction(1, 25)
    encoder.options = {"qp": str(quantiser), "preset": "veryfast", "threads": "1"}
    packets = [*encoder.encode(frame), *encoder.encode(None)]
    decoder = av.CodecContext.create("h264", "r")
    frames = [shown for packet in [*packets, None] for shown in decoder.decode(packet)]
    return np.asarray(frames[0].to_ndarray(format="bgr24"), np.uint8)


VERSIONS: Final[Mapping[str, Callable[[Picture, np.random.Generator], Picture]]] = {
    "as taken": _as_taken,
    "soft, JPEG 40 to 60": _soft,
    "sharpened, JPEG 45 to 65": _sharpened,
    "H.264 at a low rate": _video,
    "screen shot of a video": _screen_shot,
    "dim, blue": _dim,
    "hazy, yellow": _hazy,
    "shadows": _as_taken,
    "turned away": _as_taken,
}
"""Name -> change of the picture. Shadows and turned signs also need the boxes, see :func:`version`."""
