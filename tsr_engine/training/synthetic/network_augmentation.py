"""Makes training views of many crops at once in PyTorch; :mod:`~.classifier_augmentation` makes them of one crop.

They change box errors, perspective, drawing, light, focus, distance and compression. Equal generators give equal views
on the same device.
"""

from __future__ import annotations

import math
from typing import Final

import torch
from torch import Tensor
from torch.nn import functional

from tsr_engine.recognition.descriptor import MARGIN, SIDE
from tsr_engine.training.synthetic.classifier_augmentation import ASPECT, SCALE, SHIFT

__all__ = ["views"]

_PARTS: Final = 16
"""Number of views in a part of a batch with the same blur and distance."""
_MIN_CROP_PX: Final = 9
"""Smallest side to which a crop is reduced, px."""
_LUMA: Final = (0.299, 0.587, 0.114)
_TABLE: Final = (
    (16, 11, 10, 16, 24, 40, 51, 61), (12, 12, 14, 19, 26, 58, 60, 55), (14, 13, 16, 24, 40, 57, 69, 56),
    (14, 17, 22, 29, 51, 87, 80, 62), (18, 22, 37, 56, 68, 109, 103, 77), (24, 35, 55, 64, 81, 104, 113, 92),
    (49, 64, 78, 87, 103, 121, 120, 101), (72, 92, 95, 98, 112, 100, 103, 99),
)  # fmt: skip
"""Quantisation steps of JPEG at quality 50 (ITU-T T.81, annex K)."""


def views(
    pixels: Tensor, boxes: Tensor, bends: Tensor, turns: Tensor, generator: torch.Generator, strength: float
) -> Tensor:
    """Make one random view of each crop.

    Args:
        pixels: shape (n, s, s, 3), uint8, BGR, n a multiple of 16.
        boxes: shape (n, 4), the signs, as shares of the picture's side.
        bends: shape (n,), strength by which the drawing is bent, as a share of the sign's side; 0: no bending.
        turns: shape (n,), additional rotation of the sign, radians.
        generator: source of all randomness, on the device of ``pixels``.
        strength: scales the box errors and how often distance, blur and compression are applied, in [0, 1].

    Returns:
        Shape (n, 3, 48, 48), float32, whole numbers from 0 to 255.
    """
    draw = _Draw(generator, pixels.device)
    seen = _warped(pixels, boxes, bends, turns, draw, strength)
    seen = _lit(_occluded(seen, draw), draw)
    return _optics(seen, draw, strength).clamp(0, 255).round()


class _Draw:
    """Random numbers on a device."""

    def __init__(self, generator: torch.Generator, device: torch.device) -> None:
        self.generator, self.device = generator, device

    def share(self, *shape: int) -> Tensor:
        """Uniform in [0, 1)."""
        return torch.rand(shape, generator=self.generator, device=self.device)

    def spread(self, *shape: int) -> Tensor:
        """Uniform in [-1, 1)."""
        return 2 * self.share(*shape) - 1

    def normal(self, *shape: int) -> Tensor:
        return torch.randn(shape, generator=self.generator, device=self.device)

    def now(self, chance: float, *shape: int) -> Tensor:
        """True with a probability."""
        return self.share(*shape) < chance


def _warped(pixels: Tensor, boxes: Tensor, bends: Tensor, turns: Tensor, draw: _Draw, strength: float) -> Tensor:
    """Apply box errors, rotation, shear and perspective; a smooth random field bends the inner drawing."""
    count = len(pixels)
    amount = 1.15 * strength * draw.share(count, 1).sqrt()
    error = draw.spread(count, 5) * amount
    side = boxes[:, 2:] - boxes[:, :2]
    centre = (boxes[:, :2] + boxes[:, 2:]) / 2 + SHIFT * error[:, :2] * side
    side = (
        side
        * (1 + SCALE * error[:, 2:3])
        * (1 + ASPECT * error[:, 3:5] * torch.where(draw.now(0.2, count, 1), 2.5, 1.0))
        * (1 + 2 * MARGIN)
    )
    angle = turns + 0.22 * draw.spread(count) * amount[:, 0]
    shear, tilt = 0.1 * draw.spread(count) * amount[:, 0], 0.14 * draw.spread(count, 2) * amount
    steps = (torch.arange(SIDE, device=pixels.device) + 0.5) / SIDE - 0.5
    v, u = torch.meshgrid(steps, steps, indexing="ij")
    u, v = u.expand(count, -1, -1), v.expand(count, -1, -1)
    field = functional.interpolate(draw.spread(count, 2, 4, 4), (SIDE, SIDE), mode="bicubic", align_corners=True)
    inside = (1 - 2 * (u * u + v * v).sqrt()).clamp(min=0)  # the outline moves little
    zoom = 4 * draw.spread(count)[:, None, None] * inside
    bend = bends[:, None, None]
    field = field * (0.3 + inside)[:, None] * bend[:, None]
    u, v = u * (1 + bend * zoom) + field[:, 0], v * (1 + bend * zoom) + field[:, 1]
    cos, sin = angle.cos()[:, None, None], angle.sin()[:, None, None]
    depth = 1 + tilt[:, 0, None, None] * u + tilt[:, 1, None, None] * v
    x = (u * cos + v * (shear[:, None, None] - sin)) * side[:, 0, None, None] / depth + centre[:, 0, None, None]
    y = (u * sin + v * cos) * side[:, 1, None, None] / depth + centre[:, 1, None, None]
    grid = torch.stack([2 * x - 1, 2 * y - 1], dim=-1)
    source = pixels.permute(0, 3, 1, 2).float()
    return functional.grid_sample(source, grid, mode="bilinear", padding_mode="border", align_corners=False)


def _occluded(seen: Tensor, draw: _Draw) -> Tensor:
    """Sometimes put an object in front: a leaf, a pole, the edge of a lorry."""
    count = len(seen)
    centre, half = draw.spread(count, 2), 0.05 + 0.25 * draw.share(count, 2)
    centre = centre / centre.abs().amax(1, keepdim=True).clamp(min=1e-6) * (0.35 + 0.65 * draw.share(count, 1))
    steps = (torch.arange(SIDE, device=seen.device) + 0.5) / SIDE * 2 - 1
    across = (steps - centre[:, :1]).abs() < 2 * half[:, :1]
    down = (steps - centre[:, 1:]).abs() < 2 * half[:, 1:]
    hidden = (down[:, :, None] & across[:, None, :] & draw.now(0.12, count, 1, 1))[:, None]
    paint = 255 * draw.share(count, 3, 1, 1) * draw.share(count, 1, 1, 1) + 12 * draw.normal(count, 3, SIDE, SIDE)
    return torch.where(hidden, paint, seen)


def _lit(seen: Tensor, draw: _Draw) -> Tensor:
    """Apply gamma, exposure, haze, white balance, fading, a shadow's edge and falling-off light."""
    count = len(seen)
    one = (count, 1, 1, 1)
    x = (seen / 255).clamp(0, 1)
    x = torch.where(draw.now(0.5, *one), x ** (0.6 * draw.spread(*one)).exp(), x)
    mean = x.mean((1, 2, 3), keepdim=True)
    stretched = (x - mean) * (1.4 * draw.share(*one) - 0.9).exp() + mean * (1.7 * draw.share(*one) - 1.1).exp()
    x = torch.where(draw.now(0.6, *one), stretched, x)
    grey = (x * torch.tensor(_LUMA[::-1], device=x.device)[None, :, None, None]).sum(1, keepdim=True)
    x = torch.where(draw.now(0.3, *one), grey + (x - grey) * (0.2 + 1.1 * draw.share(*one)), x)
    x = torch.where(draw.now(0.4, *one), x * (0.15 * draw.spread(count, 3, 1, 1)).exp(), x)
    steps = (torch.arange(SIDE, device=x.device) + 0.5) / SIDE - 0.5
    angle = 2 * math.pi * draw.share(*one)
    along = angle.cos() * steps[None, None, None, :] + angle.sin() * steps[None, None, :, None]
    edge = (along - 0.35 * draw.spread(*one)) * (4 + 60 * draw.share(*one))
    x = torch.where(draw.now(0.15, *one), x * (1 - (0.2 + 0.5 * draw.share(*one)) * edge.sigmoid()), x)
    x = torch.where(draw.now(0.25, *one), x * (1 + 1.2 * draw.spread(*one) * along), x)
    slow = functional.interpolate(functional.avg_pool2d(x, 8), (SIDE, SIDE), mode="bilinear", align_corners=False)
    x = torch.where(draw.now(0.25, *one), x + (1.7 * draw.share(*one) - 0.6) * (x - slow), x)
    away = (steps[None, None, None, :] - 0.6 * draw.spread(*one)) ** 2 + (
        steps[None, None, :, None] - 0.6 * draw.spread(*one)
    ) ** 2
    glare = (-away / (0.05 + 0.5 * draw.share(*one)) ** 2).exp() * 0.8 * draw.share(*one)
    x = torch.where(draw.now(0.12, *one), x + glare * (1 - x), x)
    return 255 * x.clamp(0, 1)


def _optics(seen: Tensor, draw: _Draw, often: float) -> Tensor:
    """Apply focus, motion, sharpening, distance, noise and compression, in the order of a camera."""
    out = []
    # One draw for all parts: reading a number back waits for the device.
    numbers = torch.rand((_PARTS, 8)).tolist()
    for part, number in zip(seen.chunk(_PARTS), numbers, strict=True):
        x, (blur, amount, turn, far, size, code, sharp, halved) = part, number
        if blur < 0.25 * often:
            x = _filtered(x, _gaussian(0.4 + 1.8 * amount))
        elif blur < 0.45 * often:
            x = _filtered(x, _streak(2 + 5 * amount, math.pi * turn))
        small = SIDE
        if far < 0.55 * often:
            small = _MIN_CROP_PX + int(size * (SIDE - 4 - _MIN_CROP_PX))
            x = functional.interpolate(x, (small, small), mode="bilinear", antialias=True)
        if sharp < 0.2 * often:
            x = x + (0.3 + 1.5 * amount) * (x - _filtered(x, _gaussian(0.8)))
        count = len(x)
        noisy = draw.now(0.25, count, 1, 1, 1) * (1 + 11 * draw.share(count, 1, 1, 1))
        x = (x + noisy * draw.normal(*x.shape)).clamp(0, 255)
        if code < 0.35 * often:
            x = _coded(x, 12 + 70 * draw.share(count), halved < 0.6)
        if small != SIDE:
            x = functional.interpolate(x, (SIDE, SIDE), mode="bilinear", align_corners=False)
        out.append(x)
    return torch.cat(out)


def _filtered(x: Tensor, kernel: Tensor) -> Tensor:
    reach = len(kernel) // 2
    count, channels, height, width = x.shape
    wide = functional.pad(x, (reach,) * 4, mode="replicate")
    wide = wide.reshape(count * channels, 1, height + 2 * reach, width + 2 * reach)
    return functional.conv2d(wide, kernel[None, None].to(x)).reshape(count, channels, height, width)


def _gaussian(sigma: float) -> Tensor:
    line = torch.exp(-0.5 * (torch.arange(-4, 5) / sigma) ** 2)
    kernel = line[:, None] * line
    return kernel / kernel.sum()


def _streak(length: float, angle: float) -> Tensor:
    """A motion-blur kernel: a line through the centre."""
    y, x = torch.meshgrid(torch.arange(-4.0, 5), torch.arange(-4.0, 5), indexing="ij")
    along, across = x * math.cos(angle) + y * math.sin(angle), y * math.cos(angle) - x * math.sin(angle)
    kernel = (1 - across.abs()).clamp(min=0) * (length / 2 + 0.5 - along.abs()).clamp(0, 1)
    return kernel / kernel.sum()


def _coded(x: Tensor, quality: Tensor, halved: bool) -> Tensor:
    """Apply JPEG: 8x8 cosine transform, quantisation by quality, colour at half or full resolution."""
    size = x.shape[-1]
    room = -size % 16
    b, g, r = functional.pad(x, (0, room, 0, room), mode="replicate").unbind(1)
    luma = _LUMA[0] * r + _LUMA[1] * g + _LUMA[2] * b
    colour = torch.stack([0.564 * (b - luma), 0.713 * (r - luma)], dim=1)
    steps = torch.where(quality < 50, 50 / quality, 2 - quality / 50)
    luma = _stepped(luma[:, None] - 128, steps) + 128
    if halved:
        colour = functional.interpolate(_stepped(functional.avg_pool2d(colour, 2), steps), scale_factor=2.0)
    else:
        colour = _stepped(colour, steps)
    b, r = luma[:, 0] + colour[:, 0] / 0.564, luma[:, 0] + colour[:, 1] / 0.713
    g = (luma[:, 0] - _LUMA[0] * r - _LUMA[2] * b) / _LUMA[1]
    return torch.stack([b, g, r], dim=1)[..., :size, :size].clamp(0, 255)


def _stepped(x: Tensor, steps: Tensor) -> Tensor:
    count, channels, height, width = x.shape
    k, n = torch.meshgrid(torch.arange(8.0), torch.arange(8.0), indexing="ij")
    cosine = torch.cos(math.pi * (n + 0.5) * k / 8) / 2
    cosine[0] /= math.sqrt(2)
    cosine = cosine.to(x)
    table = torch.tensor(_TABLE, dtype=torch.float32).to(x) * steps[:, None, None, None, None, None]
    blocks = x.reshape(count, channels, height // 8, 8, width // 8, 8).permute(0, 1, 2, 4, 3, 5)
    found = cosine @ blocks @ cosine.T
    found = (found / table).round() * table
    return (cosine.T @ found @ cosine).permute(0, 1, 2, 4, 3, 5).reshape(count, channels, height, width)
