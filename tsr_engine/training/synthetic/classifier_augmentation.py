"""Makes training views of sign crops with the box errors, perspective, light, blur and compression of real videos.

Every view is drawn from a ``numpy.random.Generator``: equal states give equal views.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterator
from dataclasses import dataclass

import cv2
import numba as nb
import numpy as np
from numpy.typing import NDArray

from tsr_engine.io.gtsrb import CropItem, read_picture
from tsr_engine.labels.files import DEFAULT, shipped_set
from tsr_engine.recognition.descriptor import MARGIN, SIDE
from tsr_engine.recognition.gtsrb_classes import CLASSES_AFTER_HALF_TURN
from tsr_engine.records import FloatArray, Picture

MAX_CROP_PX = 64
"""Signs larger than this are reduced on loading, px: slightly above the descriptor's own size."""
SHIFT = 0.11
"""Largest box shift, as a share of the sign's side."""
SCALE = 0.12
"""Largest box scale error."""
ASPECT = 0.06
"""Largest additional error of width and of height."""
BACKGROUND = -1
"""Class of crops without a sign."""
ROUND = frozenset({40})
"""Classes with rotationally symmetric symbols: rotated by any angle, the sign keeps its class."""
_MIRRORED = shipped_set(DEFAULT).mirror_images()
_TURNED = dict(CLASSES_AFTER_HALF_TURN)


@dataclass(frozen=True, slots=True)
class LoadedCrop:
    """A decoded training picture."""

    pixels: Picture
    box: FloatArray
    """The sign in ``pixels``, shape (4,)."""
    class_id: int


def load_crop(item: CropItem) -> LoadedCrop:
    """Decode one training item; large signs are reduced to ``MAX_CROP_PX`` px.

    Raises:
        InputError: the picture is unreadable.
        ValueError: the item has no class.
    """
    if item.class_id is None:
        raise ValueError(f"A training picture needs a class. {item.path} has none.")
    picture = read_picture(item)
    height, width = picture.shape[:2]
    box = np.array(item.roi if item.roi is not None else _inner(width, height), dtype=np.float64)
    return _reduced(picture, box, item.class_id)


def surrounded_crop(picture: Picture, box: FloatArray, class_id: int) -> LoadedCrop:
    """Crop a box of a picture with half its side around it, so that views can shift; large boxes are reduced.

    Args:
        picture: BGR, uint8.
        box: shape (4,), must overlap the picture.
        class_id: class of the sign; ``BACKGROUND``: no sign.
    """
    reach = 0.5 * max(box[2] - box[0], box[3] - box[1]) + 2
    left, top = np.maximum(0, np.floor(box[:2] - reach)).astype(int)
    right, bottom = np.ceil(box[2:] + reach).astype(int)
    return _reduced(picture[top:bottom, left:right].copy(), box - np.array([left, top] * 2), class_id)


def _reduced(picture: Picture, box: FloatArray, class_id: int) -> LoadedCrop:
    height, width = picture.shape[:2]
    side = max(box[2] - box[0], box[3] - box[1])
    if side > MAX_CROP_PX:
        size = (max(1, round(width * MAX_CROP_PX / side)), max(1, round(height * MAX_CROP_PX / side)))
        box = box * np.array([size[0] / width, size[1] / height] * 2)
        picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
    return LoadedCrop(picture, box, class_id)


def _inner(width: int, height: int) -> tuple[float, float, float, float]:
    """The sign's box in a picture with the classifier's margin and no ROI."""
    dx, dy = (side * MARGIN / (1 + 2 * MARGIN) for side in (width, height))
    return dx, dy, width - dx, height - dy


def box_view(crop: LoadedCrop, box: FloatArray) -> Picture:
    """Resample a box of a crop and its margin to a 48x48 patch; the border is replicated."""
    x1, y1, x2, y2 = box
    grown = 1 + 2 * MARGIN
    matrix = np.array(
        [[(x2 - x1) * grown, 0, (x1 + x2) / 2], [0, (y2 - y1) * grown, (y1 + y2) / 2], [0, 0, 1]], dtype=np.float64
    )
    patch: Picture = _warp(crop.pixels, matrix)
    return patch


def plain_view(crop: LoadedCrop) -> Picture:
    """The unchanged crop as a 48x48 patch."""
    return box_view(crop, crop.box)


def shaken_box(box: FloatArray, generator: np.random.Generator, amount: float = 1.0) -> FloatArray:
    """A box with a detector's errors: shift, scale and aspect.

    Args:
        box: shape (4,).
        generator: source of the errors.
        amount: 1: shifts up to 11 %, scales up to 12 % and aspects up to 6 % of the box's side.
    """
    draw = iter((2 * amount * (generator.random(5) - 0.5)).tolist())
    return np.array(_shake(box, draw))


def _shake(box: FloatArray, draw: Iterator[float]) -> tuple[float, float, float, float]:
    x1, y1, x2, y2 = box.tolist()
    width, height = x2 - x1, y2 - y1
    cx, cy = (x1 + x2) / 2 + SHIFT * next(draw) * width, (y1 + y2) / 2 + SHIFT * next(draw) * height
    scale = 1 + SCALE * next(draw)
    width, height = width * scale * (1 + ASPECT * next(draw)), height * scale * (1 + ASPECT * next(draw))
    return cx - width / 2, cy - height / 2, cx + width / 2, cy + height / 2


def jittered_view(
    crop: LoadedCrop, generator: np.random.Generator, strength: float = 1.0, unseen: Container[int] = ()
) -> tuple[Picture, int]:
    """A random view of a crop and its class, which mirroring may change.

    Args:
        crop: the picture.
        generator: source of the view.
        strength: scales the box errors and how often distance, blur and compression are applied, in [0, 1].
        unseen: classes that no mirrored or rotated view may show.
    """
    # The root makes large errors more frequent than small ones: such views are misread most often.
    amount = 1.15 * strength * math.sqrt(generator.random())
    draw = iter((2 * amount * (generator.random(11) - 0.5)).tolist())
    x1, y1, x2, y2 = _shake(crop.box, draw)
    angle, shear, tilt_x, tilt_y = 0.16 * next(draw), 0.08 * next(draw), 0.1 * next(draw), 0.1 * next(draw)
    if crop.class_id in ROUND:
        angle += 2 * math.pi * generator.random()
    cos, sin, grown = math.cos(angle), math.sin(angle), 1 + 2 * MARGIN
    width, height, cx, cy = (x2 - x1) * grown, (y2 - y1) * grown, (x1 + x2) / 2, (y1 + y2) / 2
    matrix = np.array(
        [
            [width * cos + cx * tilt_x, width * (shear - sin) + cx * tilt_y, cx],
            [height * sin + cy * tilt_x, height * cos + cy * tilt_y, cy],
            [tilt_x, tilt_y, 1.0],
        ]
    )
    patch, class_id = disturbed(_warp(crop.pixels, matrix), generator, strength), crop.class_id
    mirror, turn = (generator.random(2) < 0.5).tolist()
    if mirror and class_id in _MIRRORED and _MIRRORED[class_id] not in unseen:
        patch, class_id = patch[:, ::-1], _MIRRORED[class_id]
    if turn and class_id in _TURNED and _TURNED[class_id] not in unseen:
        patch, class_id = patch[::-1, ::-1], _TURNED[class_id]
    return np.ascontiguousarray(patch), class_id


def view_strength(done: float, calm: float, calm_strength: float) -> float:
    """Strength of the views at a point of a training: the last views are close to what will be read.

    Args:
        done: share of the steps that are done, in [0, 1].
        calm: share of the steps, at the end, over which the strength falls from 1.
        calm_strength: strength of the last views, in [0, 1].
    """
    if calm <= 0:
        return 1.0
    fallen = min(max((done - 1 + calm) / calm, 0.0), 1.0)
    return 1.0 + fallen * (calm_strength - 1.0)


def disturbed(patch: Picture, generator: np.random.Generator, strength: float) -> Picture:
    """Change a 48x48 patch as another camera, another light and distance would.

    Args:
        patch: BGR, uint8.
        generator: source of the changes.
        strength: how often distance, blur and compression are applied, in [0, 1].
    """
    return _light(_optics(patch, generator, strength), generator)


@nb.njit(cache=True, nogil=True, fastmath=True)
def _warp(pixels, matrix):  # type: ignore[no-untyped-def]
    """Bilinear 48x48 patch; ``matrix`` maps ``(u, v, 1)``, u and v in [-1/2, 1/2], to homogeneous pixel edges."""
    height, width = pixels.shape[:2]
    patch = np.empty((SIDE, SIDE, 3), dtype=np.uint8)
    for j in range(SIDE):
        v = (j + 0.5) / SIDE - 0.5
        for i in range(SIDE):
            u = (i + 0.5) / SIDE - 0.5
            z = matrix[2, 0] * u + matrix[2, 1] * v + matrix[2, 2]
            x = (matrix[0, 0] * u + matrix[0, 1] * v + matrix[0, 2]) / z - 0.5
            y = (matrix[1, 0] * u + matrix[1, 1] * v + matrix[1, 2]) / z - 0.5
            x = min(max(x, 0.0), width - 1.0)
            y = min(max(y, 0.0), height - 1.0)
            x0, y0 = int(x), int(y)
            x1, y1 = min(x0 + 1, width - 1), min(y0 + 1, height - 1)
            fx, fy = np.float32(x - x0), np.float32(y - y0)
            for c in range(3):
                top = pixels[y0, x0, c] + fx * (np.float32(pixels[y0, x1, c]) - np.float32(pixels[y0, x0, c]))
                bottom = pixels[y1, x0, c] + fx * (np.float32(pixels[y1, x1, c]) - np.float32(pixels[y1, x0, c]))
                patch[j, i, c] = np.uint8(top + fy * (bottom - top) + np.float32(0.5))
    return patch


def _optics(patch: Picture, generator: np.random.Generator, often: float) -> Picture:
    """Apply focus, motion, distance and compression, in the order of a camera."""
    far, blur, code, size, strength, quality = generator.random(6).tolist()
    if blur < 0.2 * often:
        smooth = cv2.GaussianBlur(patch, (0, 0), 0.5 + 1.7 * strength, borderType=cv2.BORDER_REPLICATE)
        patch = np.asarray(smooth, dtype=np.uint8)
    elif blur < 0.4 * often:
        streak = cv2.filter2D(patch, -1, _streak(generator), borderType=cv2.BORDER_REPLICATE)
        patch = np.asarray(streak, dtype=np.uint8)
    if far < 0.4 * often:
        small = 13 + int(size * (SIDE - 13))
        patch = np.asarray(cv2.resize(patch, (small, small), interpolation=cv2.INTER_AREA), dtype=np.uint8)
    if code < 0.25 * often:
        # At the sign's own size, the coder's 8 px blocks cover as much of a small sign as in a video.
        _, packed = cv2.imencode(".jpg", patch, [cv2.IMWRITE_JPEG_QUALITY, 20 + int(60 * quality)])
        patch = np.asarray(cv2.imdecode(packed, cv2.IMREAD_COLOR), dtype=np.uint8)
    if patch.shape[0] != SIDE:
        patch = np.asarray(cv2.resize(patch, (SIDE, SIDE), interpolation=cv2.INTER_LINEAR), dtype=np.uint8)
    return patch


def _streak(generator: np.random.Generator) -> NDArray[np.float32]:
    """A motion-blur kernel: a line of 3 to 7 px through the centre."""
    length = int(generator.integers(3, 8))
    angle = math.pi * generator.random()
    kernel = np.zeros((7, 7), dtype=np.float32)
    for step in np.linspace(-0.5, 0.5, 2 * length).tolist():
        reach = step * (length - 1)
        kernel[round(3 + reach * math.sin(angle)), round(3 + reach * math.cos(angle))] += 1
    return np.asarray(kernel / kernel.sum(), dtype=np.float32)


def _light(patch: Picture, generator: np.random.Generator) -> Picture:
    """Apply gamma, exposure, haze, white balance, a shadow's edge and sensor noise."""
    draw = generator.random(14).tolist()
    levels = np.arange(256, dtype=np.float32) / np.float32(255)
    if draw[0] < 0.5:
        levels **= math.exp(draw[1] - 0.5)
    if draw[2] < 0.6:
        mean = sum(cv2.mean(patch)[:3]) / (3 * 255)
        levels = (levels - mean) * math.exp(1.5 * draw[3] - 1.0) + mean * math.exp(1.4 * draw[4] - 0.7)
    balance = [math.exp(0.3 * d - 0.15) if draw[5] < 0.4 else 1.0 for d in draw[6:9]]
    table = np.minimum(np.maximum(levels * 255, 0), 255)[:, None] * np.array(balance, dtype=np.float32)
    shadow = 0.3 + 0.5 * draw[10] if draw[9] < 0.12 else 1.0
    angle, offset = 2 * math.pi * draw[11], (draw[12] - 0.5) * 0.6 * SIDE
    noise = generator.standard_normal((SIDE, SIDE), dtype=np.float32) if draw[13] < 0.15 else None
    if noise is None:
        noise, strength = np.zeros((1, 1), dtype=np.float32), 0.0
    else:
        strength = 1 + 7 * generator.random()
    lit: Picture = _expose(patch, table, shadow, math.cos(angle), math.sin(angle), offset, noise, np.float32(strength))
    return lit


@nb.njit(cache=True, nogil=True, fastmath=True)
def _expose(patch, table, shadow, cos, sin, offset, noise, strength):  # type: ignore[no-untyped-def]
    """Look up the levels, darken one side of a line, and add noise that shifted colour channels share."""
    out = np.empty_like(patch)
    period = len(noise)
    for y in range(SIDE):
        for x in range(SIDE):
            dark = (x - SIDE / 2) * cos + (y - SIDE / 2) * sin > offset
            gain = np.float32(shadow) if dark else np.float32(1)
            for c in range(3):
                value = table[patch[y, x, c], c] * gain
                if strength > 0:
                    value += strength * noise[(y + 17 * c) % period, (x + 5 * c) % period]
                out[y, x, c] = np.uint8(min(max(value, np.float32(0)), np.float32(255)))
    return out
