"""The network's architecture in numbers, shared by the training and the ONNX writer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

STRIDE: Final = 8
"""Side of an output cell, px of the picture."""
MAX_STRIDE: Final = 32
"""The sides of the input are multiples of this, px."""


@dataclass(frozen=True, slots=True)
class Convolution:
    """A convolution with its batch normalisation, followed by ReLU except at the output.

    Attributes:
        name: name of its weights.
        inputs: number of input channels.
        outputs: number of output channels.
        size: side of the kernel; the padding keeps the shape for stride 1.
        stride: 1 or 2.
    """

    name: str
    inputs: int
    outputs: int
    size: int = 3
    stride: int = 1


def _block(name: str, channels: int) -> list[Convolution]:
    return [Convolution(f"{name}_a", channels, channels), Convolution(f"{name}_b", channels, channels)]


CONVOLUTIONS: Final = {
    c.name: c
    for c in (
        Convolution("stem", 3, 16, stride=2),
        Convolution("down4", 16, 32, stride=2),
        Convolution("at4", 32, 32),
        Convolution("down8", 32, 48, stride=2),
        *_block("at8", 48),
        *_block("at8_again", 48),
        Convolution("down16", 48, 80, stride=2),
        *_block("at16", 80),
        Convolution("down32", 80, 80, stride=2),
        Convolution("at32", 80, 80),
        Convolution("side32", 80, 48, size=1),
        Convolution("side16", 80, 48, size=1),
        Convolution("side8", 48, 48, size=1),
        Convolution("merge", 48, 48),
        Convolution("head", 48, 48),
        Convolution("answer", 48, 5, size=1),
    )
}
"""By name. Blocks add their input to their answer before the last ReLU; the sides of strides 32, 16 and 8 are enlarged
and added on the way back to stride 8. The five channels of the answer: log-odds of a sign's centre, and the logarithms
of the distances to its left, upper, right and lower edge in cells."""
