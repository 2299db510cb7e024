"""Changes training patches at random as light, optics, cameras and compression do.

Low sun, glare, deep shade and blur matter on real roads and are rare in benchmark scenes.
"""

from __future__ import annotations

import cv2
import numpy as np

from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.synthetic.yellow_grounds import sometimes_yellow


def relight(picture: Picture, rng: np.random.Generator) -> Picture:
    """Change the light of a BGR picture: exposure, gamma, veiling glare or shade, colour temperature, noise."""
    x = picture.astype(np.float32) / 255.0
    x = x ** np.float32(np.exp(rng.uniform(-0.5, 0.5)))
    # Deep shade loses three stops and low sun saturates; both are clipped and quantised as in a camera.
    x *= np.float32(np.exp(rng.uniform(-2.0, 0.9)))
    if rng.random() < 0.3:
        veil = np.float32(rng.uniform(0.1, 0.55))
        tint = rng.uniform(0.8, 1.0, 3).astype(np.float32)
        x = x * (1 - veil) + veil * tint
    if rng.random() < 0.4:
        warmth = np.float32(rng.uniform(-0.15, 0.15))
        x *= np.array([1 - warmth, 1, 1 + warmth], np.float32)
    if rng.random() < 0.3:  # light that falls off across the patch
        h, w = x.shape[:2]
        angle = rng.uniform(0, 2 * np.pi)
        yy, xx = np.mgrid[0:h, 0:w].astype(np.float32)
        ramp = (np.cos(angle) * (xx / w - 0.5) + np.sin(angle) * (yy / h - 0.5)) * rng.uniform(0.2, 0.9)
        x *= (1 + ramp.astype(np.float32))[..., None]
    x += rng.normal(0, rng.uniform(0.0, 0.02), x.shape).astype(np.float32)
    return np.asarray(np.clip(x * 255.0, 0, 255), dtype=np.uint8)


def soften(picture: Picture, rng: np.random.Generator) -> Picture:
    """Remove detail from a BGR picture: defocus, motion blur, lower resolution or JPEG blocks."""
    kind = rng.integers(4)
    h, w = picture.shape[:2]
    if kind == 0:
        out = cv2.GaussianBlur(picture, (0, 0), float(rng.uniform(0.4, 1.1)))
    elif kind == 1:
        length = int(rng.integers(2, 5))
        out = cv2.blur(picture, (length, 1) if rng.random() < 0.6 else (1, length))
    elif kind == 2:
        share = float(rng.uniform(0.55, 0.9))
        small = cv2.resize(picture, (max(2, int(w * share)), max(2, int(h * share))), interpolation=cv2.INTER_AREA)
        out = cv2.resize(small, (w, h), interpolation=cv2.INTER_LINEAR)
    else:
        _, code = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(25, 75))])
        out = cv2.imdecode(code, cv2.IMREAD_COLOR)
    return np.asarray(out, dtype=np.uint8)


def augment_picture(
    picture: Picture,
    box: FloatArray,
    rng: np.random.Generator,
    *,
    relit: float,
    softened: float,
    other_cameras: float,
    shaded: float,
    yellow: float = 0.0,
    class_id: int = -1,
) -> Picture:
    """Change a BGR picture of a sign as another moment or another camera would.

    Args:
        picture: uint8.
        box: the sign, shape (4,).
        rng: source of all changes.
        relit: probability of another light.
        softened: probability of less detail.
        other_cameras: probability of another camera, which excludes the two changes above.
        shaded: probability of a shadow on the sign.
        yellow: probability of a yellow ground, if the sign has a ground.
        class_id: class of the sign; below 0: unknown, then no ground becomes yellow.
    """
    picture = sometimes_yellow(picture, box, class_id, yellow, rng)
    if shaded and rng.random() < shaded:
        picture = shade(picture, box, rng)
    if other_cameras and rng.random() < other_cameras:
        return other_camera(picture, rng)
    if rng.random() < relit:
        picture = relight(picture, rng)
    return soften(picture, rng) if rng.random() < softened else picture


def other_camera(picture: Picture, rng: np.random.Generator) -> Picture:
    """Change a BGR picture as another camera and its coder would: colours, resolution, sharpening, compression."""
    seen = picture
    if rng.random() < 0.6:
        seen = _toned(seen, rng)
    if rng.random() < 0.5:
        share = float(rng.uniform(0.5, 0.95))
        h, w = seen.shape[:2]
        small = cv2.resize(seen, (max(2, round(w * share)), max(2, round(h * share))), interpolation=cv2.INTER_AREA)
        back = cv2.INTER_CUBIC if rng.random() < 0.5 else cv2.INTER_LINEAR
        seen = np.asarray(cv2.resize(small, (w, h), interpolation=back), dtype=np.uint8)
    if rng.random() < 0.5:
        amount = float(rng.uniform(0.3, 2.0))
        blurred = cv2.GaussianBlur(seen, (0, 0), float(rng.uniform(0.7, 2.0)))
        seen = np.asarray(cv2.addWeighted(seen, 1 + amount, blurred, -amount, 0), dtype=np.uint8)
    if rng.random() < 0.6:
        _, code = cv2.imencode(".jpg", seen, [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(22, 65))])
        seen = np.asarray(cv2.imdecode(code, cv2.IMREAD_COLOR), dtype=np.uint8)
        if rng.random() < 0.4:  # a video coder smooths block edges
            seen = np.asarray(cv2.bilateralFilter(seen, 5, 20, 1.5), dtype=np.uint8)
    return seen


def _toned(picture: Picture, rng: np.random.Generator) -> Picture:
    """Apply another camera's white balance, contrast about middle grey, gamma and saturation."""
    value = 255 * (np.arange(256) / 255) ** np.exp(rng.uniform(-0.45, 0.45))
    grey = rng.uniform(90, 150)
    value = (value - grey) * rng.uniform(0.55, 1.4) + grey + rng.uniform(-30, 30)
    table = np.clip(value[:, None] * np.exp(rng.uniform(-0.1, 0.1, 3)), 0, 255).astype(np.uint8)
    seen = cv2.LUT(picture, table[None])
    grown = float(rng.uniform(0.6, 1.4))
    light = cv2.cvtColor(cv2.cvtColor(seen, cv2.COLOR_BGR2GRAY), cv2.COLOR_GRAY2BGR)
    return np.asarray(cv2.addWeighted(seen, grown, light, 1 - grown, 0), dtype=np.uint8)


def shade(picture: Picture, box: FloatArray, rng: np.random.Generator) -> Picture:
    """Put a shadow on a sign in a BGR picture: of a pole, of an edge, or of leaves.

    Args:
        picture: uint8.
        box: the sign, shape (4,).
        rng: source of the shadow.
    """
    side = float(max(box[2] - box[0], box[3] - box[1]))
    reach = 1.5 * side
    left, top = np.maximum(0, np.floor(box[:2] - reach)).astype(int).tolist()
    right, bottom = np.ceil(box[2:] + reach).astype(int).tolist()
    part = picture[top:bottom, left:right].astype(np.float32)
    h, w = part.shape[:2]
    kind = rng.random()
    if kind < 0.3:
        grains = rng.normal(0, 1, (max(2, round(h / side * 4)), max(2, round(w / side * 4)))).astype(np.float32)
        dark = cv2.resize(grains, (w, h), interpolation=cv2.INTER_CUBIC) * 3 + np.float32(rng.uniform(-1, 1))
    else:
        x, y = (box[:2] + box[2:]) / 2 + rng.uniform(-0.35, 0.35, 2) * side - np.array([left, top])
        angle = rng.uniform(0, 2 * np.pi)
        across = np.cos(angle) * (np.arange(w) + 0.5 - x)[None] + np.sin(angle) * (np.arange(h) + 0.5 - y)[:, None]
        if kind < 0.65:
            across = np.abs(across) - rng.uniform(0.03, 0.2) * side
        dark = (-across / max(0.7, rng.uniform(0.01, 0.06) * side)).astype(np.float32)
    cover = np.clip(dark + 0.5, 0, 1)[..., None] * np.float32(rng.uniform(0.25, 0.75))
    shaded = picture.copy()
    shaded[top:bottom, left:right] = (part * (1 - cover)).astype(np.uint8)
    return shaded
