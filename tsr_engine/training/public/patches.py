"""Cuts training windows of signs with wide surroundings, jitters and relights them, and computes their channels.

Channels are computed on a patch of 96 px around a sign of 24 px and cropped afterwards, because normalisation at the
window's border needs the pixels beyond it.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.channels.quantise import channel_bytes
from tsr_engine.channels.smooth import smooth
from tsr_engine.detection.patch import cut_patch
from tsr_engine.detection.window import Window
from tsr_engine.geometry.boxes import area
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.synthetic.augment import augment_picture

PATCH: Final = 96
"""Side of a training patch, px."""


def window_features(patch: Picture, window: Window) -> NDArray[np.uint8]:
    """Features of the detector's window in the middle of a patch, shape (10 * cells * cells,), uint8."""
    cells = smooth(channel_bytes(patch, window.shrink))
    first = (cells.shape[1] - window.cells) // 2
    middle = cells[:, first : first + window.cells, first : first + window.cells]
    return np.ascontiguousarray(middle).reshape(-1)


def surroundings(picture: Picture, box: FloatArray) -> tuple[Picture, FloatArray]:
    """A copy of a sign with all that its views and displaced boxes can show, and the sign's box in it.

    Args:
        picture: BGR, uint8.
        box: the sign, shape (4,).
    """
    reach = int(2.5 * float(np.sqrt(area(box))) + 20)
    x, y = max(0, int(box[0] - reach)), max(0, int(box[1] - reach))
    return picture[y : int(box[3] + reach), x : int(box[2] + reach)].copy(), box - np.array([x, y, x, y])


def jitter(box: FloatArray, rng: np.random.Generator, shift: float, log_scale: float) -> FloatArray:
    """Move a box by up to ``shift`` of its side and scale it by up to ``exp(+-log_scale)``, uniformly."""
    dx, dy = rng.uniform(-shift, shift, 2) * np.sqrt(area(box))
    grow = np.exp(rng.uniform(-log_scale, log_scale))
    cx, cy = (box[0] + box[2]) / 2 + dx, (box[1] + box[3]) / 2 + dy
    half_w, half_h = (box[2] - box[0]) / 2 * grow, (box[3] - box[1]) / 2 * grow
    return np.array([cx - half_w, cy - half_h, cx + half_w, cy + half_h])


def random_distortion(rng: np.random.Generator, aspect: float, turn: float) -> FloatArray:
    """A stretch of constant area, then a rotation; shape (2, 2). Both are normal, cut at two standard deviations.

    Args:
        rng: randomness.
        aspect: standard deviation of the logarithm by which x grows and y shrinks.
        turn: standard deviation of the angle, degrees.
    """
    stretch = float(np.clip(rng.normal(0, aspect), -2 * aspect, 2 * aspect))
    angle = np.deg2rad(np.clip(rng.normal(0, turn), -2 * turn, 2 * turn))
    cos, sin = np.cos(angle), np.sin(angle)
    return np.asarray(np.array([[cos, -sin], [sin, cos]]) @ np.diag(np.exp([stretch, -stretch])))


def sign_windows(
    picture: Picture,
    box: FloatArray,
    window: Window,
    count: int,
    rng: np.random.Generator,
    *,
    shift: float = 0.045,
    log_scale: float = 0.06,
    aspect: float = 0.0,
    turn: float = 0.0,
    relit: float = 0.5,
    softened: float = 0.3,
    other_cameras: float = 0.0,
    shaded: float = 0.0,
    yellow: float = 0.0,
    class_id: int = -1,
) -> NDArray[np.uint8]:
    """Jittered windows of one sign.

    Args:
        picture: the scene, BGR.
        box: the sign, shape (4,).
        window: the detector's window.
        count: number of windows; the first is neither distorted nor relit nor softened.
        rng: randomness.
        shift: largest displacement as a share of the sign's side (the scan's own step is about half of this).
        log_scale: largest change of scale, natural logarithm.
        aspect: standard deviation of the stretch, natural logarithm: a sign turned away is narrower.
        turn: standard deviation of the turn in the picture's plane, degrees.
        relit: share of windows under another light.
        softened: share of windows with less detail.
        other_cameras: share of windows as another camera would have seen them, neither relit nor softened.
        shaded: share of windows with a shadow on the sign.
        yellow: share of windows with a yellow ground, if the sign has one.
        class_id: of the sign; below 0: unknown.

    Returns:
        Shape (count, features), uint8.
    """
    out = []
    middle = (PATCH + np.array([-1, -1, 1, 1]) * window.sign) / 2
    for i in range(count):
        distortion = random_distortion(rng, aspect, turn) if i and (aspect or turn) else None
        patch = cut_patch(picture, jitter(box, rng, shift, log_scale), window.sign, PATCH, distortion)
        if i:
            patch = augment_picture(
                patch, middle, rng,
                relit=relit, softened=softened, other_cameras=other_cameras, shaded=shaded,
                yellow=yellow, class_id=class_id,
            )  # fmt: skip
        if rng.random() < 0.5:
            patch = np.ascontiguousarray(patch[:, ::-1])
        out.append(window_features(patch, window))
    return np.stack(out)
