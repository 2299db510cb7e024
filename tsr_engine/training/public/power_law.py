"""Measures the exponents of the power law on pictures (Dollar et al. 2014, section 4.2)."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np

from tsr_engine.channels.compute import CHANNELS, compute_channels
from tsr_engine.records import Picture


def measure_lambdas(pictures: Iterable[Picture], shrink: int = 2, octaves: int = 2) -> tuple[float, ...]:
    """``lambda`` of each channel: mean of ``log2(mean at half the scale / mean at the scale)``.

    Args:
        pictures: BGR, uint8, shape (h, w, 3).
        shrink: cell size in px.
        octaves: number of halvings of each picture.

    Returns:
        Ten exponents; those of the three colour channels are about 0.

    Raises:
        ValueError: there are no pictures.
    """
    logs = []
    for picture in pictures:
        here = compute_channels(picture, shrink).mean((1, 2))
        for _ in range(octaves):
            h, w = picture.shape[0] // 2, picture.shape[1] // 2
            picture = np.asarray(
                cv2.resize(picture[: 2 * h, : 2 * w], (w, h), interpolation=cv2.INTER_AREA), dtype=np.uint8
            )
            half = compute_channels(picture, shrink).mean((1, 2))
            logs.append(np.log2((half + 1e-9) / (here + 1e-9)))
            here = half
    if not logs:
        raise ValueError("lambda is measured on at least one picture. Got none.")
    mean = np.mean(logs, axis=0)
    return tuple(round(float(mean[c]), 4) if c >= 3 else 0.0 for c in range(CHANNELS))
