"""Changes pictures of drives to other weather, which may cause false detections."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

import cv2
import numpy as np

from benchmarks.corruptions.video import dim
from tsr_engine.records import FloatArray, Picture

Weather = Callable[[Picture, int], Picture]
"""Maps a BGR picture and its number in the drive to the picture in this weather."""
_LAMPS: Final = 14
_BULBS: Final = np.array([[255, 255, 255], [150, 220, 255], [40, 50, 255], [80, 255, 80], [255, 120, 60]], np.float32)
"""Colours of lamps, BGR: white, sodium, tail lamp, green light, blue light."""
_STAYS: Final = 45
"""Number of frames for which a drop stays on the glass."""
_SWEEP: Final = 30
"""Number of frames between two sweeps of the wiper; a sweep takes a third of them."""


def _night(picture: Picture, ordinal: int) -> Picture:
    """Night: headlights on the road, the rest nearly black, lamps that approach and leave the picture."""
    height, width = picture.shape[:2]
    x, y = (np.arange(width) + 0.5) / width, (np.arange(height)[:, None] + 0.5) / height
    light = 0.05 + 0.6 * np.exp(-(((x - 0.5) / 0.35) ** 2)) * np.exp(-(((y - 0.75) / 0.25) ** 2))
    dark = 255 * (np.arange(256) / 255) ** 1.4
    seen = cv2.LUT(picture, dark.astype(np.float32)) * light.astype(np.float32)[..., None]
    lamps = np.zeros_like(seen)
    for number in range(_LAMPS):
        period = 60 + 7 * number
        rng = np.random.default_rng([number, (ordinal + 11 * number) // period])
        nearer = np.exp(3.0 * ((ordinal + 11 * number) % period) / period)
        middle = np.array([0.5, 0.5]) + rng.uniform((-0.1, -0.06), (0.1, 0.01)) * nearer
        place = (round(middle[0] * width), round(middle[1] * height))
        bulb = _BULBS[rng.integers(len(_BULBS))]
        for size, strength in ((4.0, 0.12), (2.0, 0.3), (1.0, 1.0)):
            colour = (strength * bulb).tolist()
            cv2.circle(lamps, place, max(1, round(size * 0.0015 * nearer * width)), colour, -1, cv2.LINE_AA)
    seen += cv2.GaussianBlur(lamps, (0, 0), width / 640)
    seen += 4 * np.random.default_rng(ordinal).standard_normal(seen.shape, np.float32)
    return np.asarray(np.clip(seen, 0, 255), np.uint8)


def _rain(picture: Picture, ordinal: int) -> Picture:
    """Rain: haze, streaks, and drops on the glass that show the road upside down."""
    height, width = picture.shape[:2]
    seen = _streaked(picture, ordinal)
    turned = cv2.GaussianBlur(cv2.flip(seen, -1), (0, 0), width / 160)
    drops = np.zeros((height, width), np.uint8)
    for number in range(30):
        own = np.random.default_rng([number, (ordinal + number) // _STAYS])
        place = own.uniform(0, (width, height)).round().astype(int).tolist()
        cv2.circle(drops, place, max(2, round(own.uniform(0.004, 0.02) * width)), 255, -1, cv2.LINE_AA)
    share = cv2.GaussianBlur(drops, (0, 0), 1.5)[..., None] / np.float32(255)
    return np.asarray(seen * (1 - share) + turned * share, np.uint8)


def _wiped(picture: Picture, ordinal: int) -> Picture:
    """Rain with a wiper: a dark blade, and a smear behind it that fades until the next sweep."""
    height, width = picture.shape[:2]
    swept = 3 * (ordinal % _SWEEP) / _SWEEP
    pivot = np.array([width / 2, 1.05 * height])
    behind = np.zeros((height, width), np.uint8)
    edge = [pivot + 1.2 * width * _towards(share) for share in np.linspace(0, min(1.0, swept), 12)]
    cv2.fillPoly(behind, [np.array([pivot, *edge]).astype(np.int32)], 255)
    clear = _streaked(picture, ordinal)
    wet = max(0.0, 0.6 - 0.2 * swept)
    smeared = cv2.addWeighted(clear, 1 - wet, cv2.blur(clear, (max(3, width // 25), 1)), wet, 0)
    seen = np.where(behind[..., None] > 0, smeared, _rain(picture, ordinal))
    if swept < 1:
        tip = pivot + 1.2 * width * _towards(swept)
        cv2.line(seen, pivot.astype(int).tolist(), tip.astype(int).tolist(), (25, 25, 25), max(3, width // 50))
    return np.asarray(seen, np.uint8)


def _streaked(picture: Picture, ordinal: int) -> Picture:
    height, width = picture.shape[:2]
    streaks = np.zeros((height, width), np.uint8)
    for x, y, length in np.random.default_rng(ordinal).uniform((0, 0, 0.02), (width, height, 0.06), (150, 3)):
        end = (round(x + 0.2 * length * height), round(y + length * height))
        cv2.line(streaks, (round(x), round(y)), end, 70, 1, cv2.LINE_AA)
    grey = cv2.addWeighted(picture, 0.65, np.full_like(picture, 150), 0.35, 0)
    return np.asarray(cv2.add(grey, cv2.merge([streaks] * 3)), np.uint8)


def _towards(share: float) -> FloatArray:
    """Direction of the blade after a share of its sweep from left to right."""
    angle = np.pi * (1 - share)
    return np.array([np.cos(angle), -np.sin(angle)])


WEATHERS: Final[Mapping[str, Weather]] = {"darkened": dim, "night": _night, "rain": _rain, "rain, wiped": _wiped}
