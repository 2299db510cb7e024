"""What light, optics and compression do to a picture: random changes for training patches.

Low sun, glare, deep shade and blur decide on real roads; scenes of a benchmark hardly hold them.
"""

from __future__ import annotations

import cv2
import numpy as np

from tsr_engine.records import Picture


def relight(picture: Picture, rng: np.random.Generator) -> Picture:
    """A BGR picture under another light: exposure, gamma, veiling glare or shade, colour temperature, noise."""
    x = picture.astype(np.float32) / 255.0
    x = x ** np.float32(np.exp(rng.uniform(-0.5, 0.5)))
    # deep shade loses three stops, low sun burns out: both are clipped and quantised as in a camera
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
    """A BGR picture with less detail: defocus, motion blur, lost resolution or JPEG blocks."""
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
