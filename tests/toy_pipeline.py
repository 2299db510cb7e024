"""A toy drive and simple parts, for tests of the frame loop without trained models.

Run as a script it tracks a video in a separate process: ``toy_pipeline.py VIDEO EVIDENCE [DELAY]``.
"""

from __future__ import annotations

import sys
import time
import zlib
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np

from tsr_engine.geometry.boxes import to_cxcywh, to_xyxy
from tsr_engine.io.video_writer import VideoWriter
from tsr_engine.params import Params
from tsr_engine.pipeline import Components, Models
from tsr_engine.protocols import PixelSource
from tsr_engine.recognition.crops import crop_bounds
from tsr_engine.records import Detections, FloatArray, Picture, Relocalisation, Sample
from tsr_engine.runs.track_video import RunRequest, track_video

WIDTH, HEIGHT, FPS = 320, 240, 25
PARAMS = Params().with_settings([("tau", 3.0), ("coast_foe_y", 0.5)])
"""A strict gate, so that the online detector has something to do."""


def sign_box(k: int, start: int = 4, length: int = 30) -> FloatArray | None:
    """The drawn sign of frame k: it grows and moves right, then is gone."""
    t = k - start
    if not 0 <= t < length:
        return None
    side = 18.0 + 0.9 * t
    return to_xyxy(np.array([150.0 + 2.0 * t, 100.0 - 0.8 * t, side, side]))


def drive_picture(k: int) -> Picture:
    """Frame k: a textured background, and one sign at a time, every 40 frames."""
    rng = np.random.default_rng(7)
    coarse = rng.integers(60, 140, (HEIGHT // 8, WIDTH // 8, 3), dtype=np.uint8)
    picture = cv2.resize(coarse, (WIDTH, HEIGHT), interpolation=cv2.INTER_CUBIC)
    box = sign_box(k % 40)
    if box is not None:
        (cx, cy, w, _), blue = to_cxcywh(box), (40, 30, 200)
        centre = (round(cx * 16), round(cy * 16))
        cv2.circle(picture, centre, round(w * 8), blue, -1, cv2.LINE_AA, 4)
        cv2.circle(picture, centre, round(w * 5), (240, 240, 240), -1, cv2.LINE_AA, 4)
        cv2.line(picture, (centre[0], centre[1] - round(w * 4)), (centre[0], centre[1] + round(w * 4)), (20, 20, 20), 3, cv2.LINE_AA, 4)  # fmt: skip  # noqa: E501
    return np.ascontiguousarray(picture)


def write_drive(path: Path, frames: int, keys: int | None = None) -> Path:
    """A lossless H.264 file of the toy drive; under load a lossy encoder is not always deterministic."""
    with VideoWriter(path, WIDTH, HEIGHT, Fraction(FPS), crf=0, key_distance=keys) as writer:
        for k in range(frames):
            writer.write(drive_picture(k))
    return path


class RedDetector:
    """Finds saturated red discs; misses every fourth frame, and is wrong now and then."""

    name = "red"

    def __init__(self, delay: float = 0.0) -> None:
        self.delay = delay
        self.calls = 0

    def detect(self, picture: Picture) -> Detections:
        """Boxes of red blobs."""
        self.calls += 1
        time.sleep(self.delay)
        b, g, r = (picture[..., i].astype(np.int16) for i in range(3))
        mask = ((r - np.maximum(b, g)) > 70).astype(np.uint8)
        seed = zlib.crc32(picture[::16, ::16].tobytes())
        n, _, stats, _ = cv2.connectedComponentsWithStats(mask)
        boxes = [stats[i, :4].astype(np.float64) for i in range(1, n) if stats[i, 4] > 60]
        if not boxes or seed % 4 == 0:
            return Detections.empty()
        found = np.array([[x, y, x + w, y + h] for x, y, w, h in boxes])
        raw = np.array([2.0 + 0.01 * (seed % 7)] * len(found))
        prior = np.full(len(found), 0.7)
        return Detections(found, raw, prior, raw + (prior - 0.5) * 1.0)


class HueClassifier:
    """Class probabilities from the mean colour of the crop."""

    margin = 0.1
    labels: tuple[str, ...] = ()

    def probabilities(self, crops: list[Picture]) -> np.ndarray:
        """One row per crop."""
        rows = []
        for crop in crops:
            logits = np.zeros(43)
            logits[int(crop.mean()) % 43] = 3.0
            logits[14] = 2.5
            e = np.exp(logits)
            rows.append((e / e.sum()).astype(np.float32))
        return np.array(rows, dtype=np.float32).reshape(-1, 43)


class TemplateLearner:
    """An online detector that matches the last positive crop."""

    def __init__(self, radius: int) -> None:
        self.radius = radius
        self.template: Picture | None = None

    def learn(self, pixels: PixelSource, box: FloatArray, label: int, frame: int) -> tuple[Sample, ...]:
        if label > 0:
            self.template = pixels.crop(*crop_bounds(box, 0.0))
        return (Sample("learned", label, "prediction", frame),)

    def relocalise(self, pixels: PixelSource, box: FloatArray) -> Relocalisation | None:
        """The best match around a box."""
        if self.template is None:
            return None
        x1, y1, x2, y2 = crop_bounds(box, 0.0)
        n = self.radius
        area = pixels.crop(x1 - n, y1 - n, x2 + n, y2 + n)
        template = cv2.resize(self.template, (x2 - x1, y2 - y1))
        response = cv2.matchTemplate(area, template, cv2.TM_CCOEFF_NORMED)
        _, best, _, (dx, dy) = cv2.minMaxLoc(response)
        shift = np.array([dx - n, dy - n, dx - n, dy - n], dtype=np.float64)
        search = np.array([x1 - n, y1 - n, x2 + n, y2 + n], dtype=np.float64)
        probability = float(1 / (1 + np.exp(-4 * (best - 0.3))))
        return Relocalisation(search, box + shift, float(best), probability, box, 0.0, response.size)


def components(params: Params = PARAMS, delay: float = 0.0) -> Components:
    def make_online(pixels: PixelSource, box: FloatArray, frame: int) -> tuple[TemplateLearner, tuple[Sample, ...]]:
        learner = TemplateLearner(params.online.search_radius)
        return learner, learner.learn(pixels, box, 1, frame)

    parts = Models(HueClassifier(), make_online)
    return Components(RedDetector(delay), parts, {"classifier": "c" * 64}, learned_lambda=1.0)


def load_components(params: Params, *_: object) -> Components:
    """Stands in for :func:`tsr_engine.pipeline.load_components`."""
    return components(params)


def main() -> None:
    video, evidence = Path(sys.argv[1]), Path(sys.argv[2])
    delay = float(sys.argv[3]) if len(sys.argv) > 3 else 0.0
    track_video(RunRequest(video, PARAMS, evidence=evidence), components(PARAMS, delay))


if __name__ == "__main__":
    main()
