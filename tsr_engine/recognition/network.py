"""Features of sign crops by a small convolutional network, in place of descriptor and feature map.

Only training needs PyTorch (``tsr train network``). Here the layers are sums in a fixed order, so the bits depend
neither on threads nor on the processor. Most outputs of a layer are 0; the loops skip these products, which makes them
faster than OpenCV's convolutions.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numba as nb
import numpy as np
from numpy.typing import NDArray

from tsr_engine.recognition.descriptor import MARGIN, SIDE

FEATURES: Final = 256
"""Number of features."""
MIN_SPREAD: Final = 12.0
"""Least divisor of a crop's values, grey levels; above it, the divisor is their standard deviation."""

Array = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Layer:
    """A convolution followed by ``max(0, .)``.

    Attributes:
        inputs: channels in.
        outputs: channels out.
        size: side of the kernel, odd.
        stride: 1 or 2.
        is_residual: whether the layer's input is added to its output before ``max(0, .)``.
        is_padded: whether zeros surround the input, so that stride 1 keeps its size.
    """

    inputs: int
    outputs: int
    size: int
    stride: int
    is_residual: bool = False
    is_padded: bool = True

    @property
    def reach(self) -> int:
        """Width of the zeros around the input."""
        return self.size // 2 if self.is_padded else 0

    def side(self, before: int) -> int:
        """Side of the output for an input of side ``before``."""
        return (before + 2 * self.reach - self.size) // self.stride + 1


LAYERS: Final = (
    Layer(3, 32, 5, 2),
    Layer(32, 64, 3, 2),
    Layer(64, 64, 3, 1, is_residual=True),
    Layer(64, 128, 3, 2),
    Layer(128, 128, 3, 1, is_residual=True),
    Layer(128, 160, 3, 2),
    Layer(160, FEATURES, 3, 1, is_padded=False),
)
"""From a crop of 48x48 px to 3x3 places of 160 channels, and from these to the features."""
NETWORK_GEOMETRY: Final = {
    "side": SIDE,
    "margin": MARGIN,
    "layers": [[layer.inputs, layer.outputs, layer.size, layer.stride] for layer in LAYERS],
}
"""Settings of crop and layers that the weights depend on; stored and checked."""


@dataclass(frozen=True, slots=True)
class NetworkMap:
    """Weights of the network, plain float32 arrays.

    Raises:
        ValueError: a shape does not fit the layers.
    """

    kernels: tuple[Array, ...]
    """One for each layer, shape (size * size * inputs, outputs): row by row, the channels of a place together."""
    biases: tuple[Array, ...]
    """One for each layer, shape (outputs,)."""

    def __post_init__(self) -> None:
        expected = [(layer.size * layer.size * layer.inputs, layer.outputs) for layer in LAYERS]
        shapes = [kernel.shape for kernel in self.kernels]
        if shapes != expected or [bias.shape for bias in self.biases] != [(layer.outputs,) for layer in LAYERS]:
            raise ValueError(f"NetworkMap needs kernels {expected}, each with a bias. Got {shapes} instead.")

    @property
    def length(self) -> int:
        """Number of features."""
        return FEATURES

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[np.generic]], prefix: str = "") -> NetworkMap:
        """Make a map from arrays of any float type, named as by :meth:`to_arrays`.

        Raises:
            KeyError: an array is missing.
            ValueError: shapes do not fit together.
        """
        names = [f"{prefix}kernel{number}" for number in range(len(LAYERS))]
        kernels, biases = (
            tuple(np.ascontiguousarray(arrays[name + end], dtype=np.float32) for name in names) for end in ("", "_bias")
        )
        return cls(kernels, biases)

    def to_arrays(self, prefix: str = "") -> dict[str, NDArray[np.generic]]:
        """Arrays from which :meth:`from_arrays` makes a map; kernels as float16, the type of trained ones."""
        arrays: dict[str, NDArray[np.generic]] = {}
        for number, (kernel, bias) in enumerate(zip(self.kernels, self.biases, strict=True)):
            name = f"{prefix}kernel{number}"
            arrays |= {name: kernel.astype(np.float16), f"{name}_bias": bias}
        return arrays

    def of_patches(self, patches: NDArray[np.uint8], together: int = 1) -> Array:
        """Features of crops, shape (n, 48, 48, 3), BGR -> (n, 256), all >= 0.

        Args:
            patches: the crops.
            together: unused; see :class:`~.features.FeatureMap`.
        """
        sides = [SIDE]
        for layer in LAYERS:
            sides.append(layer.side(sides[-1]))
        depths = [LAYERS[0].inputs, *(layer.outputs for layer in LAYERS)]
        activations = [np.empty((side, side, depth), np.float32) for side, depth in zip(sides, depths, strict=True)]
        out = np.empty((len(patches), FEATURES), dtype=np.float32)
        for row, patch in zip(out, patches, strict=True):
            _normalise(np.ascontiguousarray(patch), activations[0])
            for layer, kernel, bias, (layer_input, layer_output) in zip(
                LAYERS, self.kernels, self.biases, pairwise(activations), strict=True
            ):
                _convolve(
                    layer_input, kernel, bias, layer.size, layer.stride, layer.reach, layer.is_residual, layer_output
                )
            row[:] = activations[-1].reshape(-1)
        return out


@nb.njit(cache=True, nogil=True)
def _normalise(patch, out):  # type: ignore[no-untyped-def]
    """Subtracts the mean of the values and divides by their spread, to cancel light and haze."""
    total, squares, count = 0, 0, patch.size
    for value in patch.flat:
        total += int(value)
        squares += int(value) * int(value)
    mean = total / count
    spread = max(np.sqrt(max(squares / count - mean * mean, 0.0)), MIN_SPREAD)
    shift, scale = np.float32(mean), np.float32(1 / spread)
    for y in range(SIDE):
        for x in range(SIDE):
            for c in range(3):
                out[y, x, c] = (np.float32(patch[y, x, c]) - shift) * scale


@nb.njit(cache=True, nogil=True)
def _convolve(layer_input, kernel, bias, size, stride, reach, is_residual, out):  # type: ignore[no-untyped-def]
    """Computes one layer: for each place, lists the inputs that are not 0 and sums their rows of the kernel."""
    height, width, inputs = layer_input.shape
    outputs = len(bias)
    rows = np.empty(size * size * inputs + 1, np.int64)
    values = np.empty(size * size * inputs + 1, np.float32)
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            count = 0
            for j in range(size):
                v = y * stride + j - reach
                if v < 0 or v >= height:
                    continue
                for i in range(size):
                    u = x * stride + i - reach
                    if u < 0 or u >= width:
                        continue
                    cell, first = layer_input[v, u], (j * size + i) * inputs
                    for c in range(inputs):  # without a branch, which the processor could not predict
                        rows[count], values[count] = first + c, cell[c]
                        count += cell[c] != 0
            _sum_rows(kernel, bias, rows, values, count, out[y, x])
            if is_residual:
                for k in range(outputs):
                    out[y, x, k] += layer_input[y, x, k]
            for k in range(outputs):
                out[y, x, k] = max(out[y, x, k], np.float32(0))


@nb.njit(cache=True, nogil=True, inline="always")
def _sum_rows(kernel, bias, rows, values, count, out):  # type: ignore[no-untyped-def]
    """Sums ``bias`` and rows times values in order; a pass adds eight rows, so that ``out`` is loaded less often."""
    for k in range(len(bias)):
        out[k] = bias[k]
    n = 0
    while n + 8 <= count:
        a, b, c, d = kernel[rows[n]], kernel[rows[n + 1]], kernel[rows[n + 2]], kernel[rows[n + 3]]
        e, f, g, h = kernel[rows[n + 4]], kernel[rows[n + 5]], kernel[rows[n + 6]], kernel[rows[n + 7]]
        p, q, r, s = values[n], values[n + 1], values[n + 2], values[n + 3]
        t, u, v, w = values[n + 4], values[n + 5], values[n + 6], values[n + 7]
        for k in range(len(bias)):
            half = out[k] + p * a[k] + q * b[k] + r * c[k] + s * d[k]
            out[k] = half + t * e[k] + u * f[k] + v * g[k] + w * h[k]
        n += 8
    while n < count:
        a, p = kernel[rows[n]], values[n]
        for k in range(len(bias)):
            out[k] += p * a[k]
        n += 1
