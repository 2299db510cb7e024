"""Encodes pictures as H.264 in MP4."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from types import TracebackType

import av
import cv2
import numpy as np
from numpy.typing import NDArray


class Encoder:
    """An MP4 file of BGR pictures at a constant rate; equal pictures give equal bytes.

    Args:
        path: File to write.
        size: Width and height, both even.
        fps: Frames per second.
        crf: Constant rate factor of x264: lower is better and larger.
    """

    def __init__(self, path: Path, size: tuple[int, int], fps: int, crf: int) -> None:
        self._container = av.open(str(path), "w", options={"movflags": "+faststart"})
        self._stream = self._container.add_stream("libx264", rate=Fraction(fps))
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = "yuv420p"
        # otherwise x264's code for AVX-512 reads memory beyond the macroblocks, and bytes differ from run to run
        exact = {"threads": "1", "x264-params": "cpu-independent=1"}
        self._stream.options = {"crf": str(crf), "preset": "medium", "g": "50", **exact}

    def __enter__(self) -> Encoder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                for packet in self._stream.encode():
                    self._container.mux(packet)
        finally:
            self._container.close()

    def add(self, picture: NDArray[np.uint8]) -> None:
        """Append a (height, width, 3) BGR picture."""
        # OpenCV's conversion, because the scaler's result depends on the memory alignment of the picture
        planes = cv2.cvtColor(picture, cv2.COLOR_BGR2YUV_I420)
        for packet in self._stream.encode(av.VideoFrame.from_ndarray(planes, format="yuv420p")):
            self._container.mux(packet)
