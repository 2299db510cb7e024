"""Perceptual hash: 64 bits that change little when a picture changes little.

The hash compares the 64 lowest frequencies of a 32 x 32 DCT with their median (after pHash 0.9.6,
``ph_dct_imagehash``). Brightness changes only the mean, which is above the median anyway. Contrast scales all values.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.records import Picture

SIDE = 32


@dataclass(frozen=True, slots=True)
class HashMemory:
    """The mean grey picture of a track's earlier crops; immutable.

    Attributes:
        mean: shape (32, 32), float32, grey values 0..255.
        count: number of crops in the mean.
    """

    mean: NDArray[np.float32]
    count: int

    @classmethod
    def empty(cls) -> HashMemory:
        """The memory of a track without crops."""
        return cls(np.zeros((SIDE, SIDE), np.float32), 0)

    def add(self, crop: Picture, limit: int | None = None) -> HashMemory:
        """The memory with one more crop.

        Args:
            crop: BGR, uint8.
            limit: the newest crop has a weight of at least ``1 / limit``, so that older crops fade; unset: plain mean.
        """
        grey = hash_picture(crop)
        count = self.count + 1
        if self.count == 0:
            return HashMemory(grey, count)
        weight = np.float32(1.0 / (count if limit is None else min(count, limit)))
        return HashMemory(self.mean + (grey - self.mean) * weight, count)

    def distance(self, crop: Picture) -> int:
        """Hamming distance, 0..64, between the hashes of the mean and of a crop: ``p_ph``.

        Raises:
            ValueError: the memory is empty.
        """
        if self.count == 0:
            raise ValueError("HashMemory.distance needs at least one earlier crop. Got an empty memory instead.")
        return hamming(hash_bits(self.mean), hash_bits(hash_picture(crop)))


def hash_picture(crop: Picture) -> NDArray[np.float32]:
    """A crop as input of the hash: grey, shape (32, 32), float32. An empty crop is black."""
    if crop.shape[0] == 0 or crop.shape[1] == 0:
        return np.zeros((SIDE, SIDE), np.float32)
    grey = crop if crop.ndim == 2 else cv2.cvtColor(crop, cv2.COLOR_BGR2GRAY)
    shrinks = min(grey.shape[:2]) > SIDE
    small = cv2.resize(grey, (SIDE, SIDE), interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR)
    return np.asarray(small, dtype=np.float32)


def hash_bits(picture: NDArray[np.float32]) -> NDArray[np.bool_]:
    """The 64 bits of a grey picture (32, 32), row by row from low to high vertical frequency."""
    low = np.asarray(cv2.dct(picture))[:8, :8].ravel()
    return np.asarray(low > np.median(low))


def perceptual_hash(picture: NDArray[np.float32]) -> int:
    """The hash of a grey picture (32, 32) as a 64-bit number, first bit highest."""
    return int.from_bytes(np.packbits(hash_bits(picture)).tobytes(), "big")


def hamming(a: NDArray[np.bool_], b: NDArray[np.bool_]) -> int:
    """Number of bits that differ."""
    return int(np.count_nonzero(a != b))
