"""Encodes H.264 of a given size fast: each group of pictures has one quantiser, chosen from the groups before it.

An encoder with rate control estimates each picture first, which takes a quarter of its time at the fastest settings.
Here a few pictures are tried, and each group corrects the next one.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Final

import av
import cv2
from av.codec.context import Flags
from av.container import OutputContainer

GROUP_SIZE: Final = 60
"""Pictures between key frames, the most that a viewer decodes for a jump."""
_BUDGET_SHARE: Final = 0.96
"""Targeted share of the budget."""
_MIN_GROUP_SIZE: Final = 15
"""Pictures of the shortest group; a key frame takes as much as eight other pictures."""
_MAX_OVERRUN: Final = 1.25
"""A group ends early when it exceeds its share by this factor, and even a short one at twice the factor. The last
group, which no other can compensate, ends when it would use up the budget at this rate."""
_TRIAL_PICTURES: Final = 8
"""Number of pictures that are tried before the first group."""
_MAX_TRIALS: Final = 4
"""Largest number of trials: far from dash-cam clips, a quantiser step saves less than ``_STEPS_PER_HALVING`` says."""
_CLOSE_STEPS: Final = 3
"""Steps from the last trial's quantiser within which no other trial is needed."""
_FIRST_QUANTISER: Final = 31
"""First quantiser tried: close to the result for most videos of 6 Mbit/s."""
_STEPS_PER_HALVING: Final = 5.5
"""Quantiser steps that halve a clip; measured on dash-cam clips between 28 and 33."""
_MAX_FINER_STEPS: Final = 6
"""Most steps by which a group may be finer than the last one, because extreme sizes are poor estimates."""
_MIN_QUANTISER, _MAX_QUANTISER = 16, 69
"""x264 counts beyond H.264's limit of 51 by dropping more coefficients."""
_OPTIONS: Final = {"preset": "ultrafast", "g": "9999", "bf": "0"}
_STITCHABLE: Final = "stitchable=1"
"""Parameter sets that do not depend on the quantiser, so one header serves all groups."""
_AVX2_ONLY: Final = ":asm=AVX2"
"""x264 instruction sets to use on processors with AVX-512, with which the encoder takes a tenth longer. Set them
only on such processors: x264 uses what it is told to without a check."""
_AVX2, _AVX_512F = 11, 13
"""``CV_CPU_AVX2`` and ``CV_CPU_AVX_512F`` of OpenCV (opencv2/core/cvdef.h), which Python does not define."""


class GroupEncoder:
    """Encodes a known number of pictures into a stream of a file."""

    def __init__(
        self, out: OutputContainer, picture: av.VideoFrame, time_base: Fraction, count: int, budget: float, threads: int
    ) -> None:
        """Open a stream.

        Args:
            out: an open container.
            picture: the first picture; the others have its size.
            time_base: of the pictures' times.
            count: number of pictures, >= 1.
            budget: target size in bytes; missed by some percent.
            threads: number of encoder threads.
        """
        self._out, self._threads, self._time_base = out, threads, time_base
        self._pictures_left, self._bytes_left = count, budget * _BUDGET_SHARE
        self._quantiser = _FIRST_QUANTISER
        self._trial_pictures: list[av.VideoFrame] = []
        self._started = False
        self._stream = out.add_stream("libx264", rate=30)
        self._configure(self._stream.codec_context, picture)
        self._stream.time_base = time_base
        self._start_group(picture)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, px."""
        return self._stream.width, self._stream.height

    def put(self, picture: av.VideoFrame) -> None:
        """Encode the next picture, in YUV 4:2:0."""
        if self._started:
            self._encode(picture)
            return
        self._trial_pictures.append(picture)
        if len(self._trial_pictures) == min(_TRIAL_PICTURES, self._pictures_left):
            self._run_trials()

    def close(self) -> None:
        """Flush the encoder."""
        self._mux(self._encoder.encode(None))

    def _run_trials(self) -> None:
        self._started = True
        for _ in range(_MAX_TRIALS):
            previous = self._quantiser
            self._choose_quantiser(
                [packet.size for picture in (*self._trial_pictures, None) for packet in self._encoder.encode(picture)]
            )
            self._start_group(self._trial_pictures[0])
            if abs(self._quantiser - previous) <= _CLOSE_STEPS:
                break
        for picture in self._trial_pictures:
            self._encode(picture)
        self._trial_pictures.clear()

    def _start_group(self, picture: av.VideoFrame) -> None:
        """Start a new group."""
        self._group_bytes = max(self._bytes_left / self._pictures_left, 1.0) * GROUP_SIZE
        self._sizes: list[int] = []
        self._group_length = 0
        self._encoder = av.CodecContext.create("libx264", "w")
        self._configure(self._encoder, picture)
        self._encoder.flags |= Flags.global_header

    def _encode(self, picture: av.VideoFrame) -> None:
        used, is_last_group = sum(self._sizes), self._pictures_left + self._group_length <= GROUP_SIZE
        expected = _expected_group_bytes(self._sizes) if is_last_group and self._sizes else used
        max_bytes = _MAX_OVERRUN * self._group_bytes
        ends_early = (self._group_length >= _MIN_GROUP_SIZE and expected > max_bytes) or used > 2 * max_bytes
        if self._group_length >= GROUP_SIZE or ends_early:
            self._mux(self._encoder.encode(None))
            self._choose_quantiser(self._sizes)
            self._start_group(picture)
        self._pictures_left -= 1
        self._group_length += 1
        self._mux(self._encoder.encode(picture))

    def _choose_quantiser(self, sizes: list[int]) -> None:
        """Choose the next quantiser by the size of a whole group like the last one."""
        target_bytes = max(self._bytes_left / self._pictures_left, 1.0) * GROUP_SIZE
        step = max(
            math.ceil(_STEPS_PER_HALVING * math.log2(_expected_group_bytes(sizes) / target_bytes)), -_MAX_FINER_STEPS
        )
        self._quantiser = min(max(self._quantiser + step, _MIN_QUANTISER), _MAX_QUANTISER)

    def _mux(self, packets: list[av.Packet]) -> None:
        for packet in packets:
            self._sizes.append(packet.size)
            self._bytes_left -= packet.size
            packet.stream = self._stream
            self._out.mux(packet)

    def _configure(self, context: av.VideoCodecContext, picture: av.VideoFrame) -> None:
        context.width, context.height, context.pix_fmt = picture.width, picture.height, "yuv420p"
        context.time_base, context.framerate = self._time_base, Fraction(30)
        context.options = {
            **_OPTIONS,
            **_instruction_options(),
            "qp": str(self._quantiser),
            "threads": str(self._threads),
        }
        for name in ("color_range", "colorspace"):
            setattr(context, name, getattr(picture, name))


def _expected_group_bytes(sizes: list[int]) -> float:
    """Expected size of the whole group, bytes."""
    others = sizes[1:] or sizes
    return sizes[0] + (GROUP_SIZE - 1) * sum(others) / len(others)


def _instruction_options() -> dict[str, str]:
    has_avx512 = cv2.checkHardwareSupport(_AVX2) and cv2.checkHardwareSupport(_AVX_512F)
    return {"x264-params": _STITCHABLE + _AVX2_ONLY * has_avx512}
