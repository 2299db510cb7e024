"""The training loss; needs `torch`."""

from __future__ import annotations

import torch
from torch import Tensor

from benchmarks.deep.architecture import STRIDE

EDGE_WEIGHT = 2.0


def loss(answer: Tensor, heatmap: Tensor, edges: Tensor, weights: Tensor) -> Tensor:
    """Focal loss of the centres (Zhou et al., Objects as Points, 2019) and generalised IoU of the boxes.

    Args:
        answer: the network's output, shape (n, 5, h, w).
        heatmap: shape (n, h, w); -1: ignored.
        edges: shape (n, 4, h, w), px.
        weights: shape (n, h, w).
    """
    logit = answer[:, 0]
    p = torch.sigmoid(logit).clamp(1e-5, 1 - 1e-5)
    centre, counted = (heatmap == 1).float(), (heatmap >= 0).float()
    positive = centre * (1 - p) ** 2 * torch.log(p)
    negative = counted * (1 - centre) * (1 - heatmap.clamp(min=0)) ** 4 * p**2 * torch.log(1 - p)
    focal = -(positive + negative).sum() / centre.sum().clamp(min=1)
    weighted = weights > 0
    if not bool(weighted.any()):
        return focal
    boxes = corners(answer[:, 1:]).permute(0, 2, 3, 1)[weighted]
    target = edges.permute(0, 2, 3, 1)[weighted]
    share = weights[weighted] / weights[weighted].sum()
    return focal + EDGE_WEIGHT * ((1 - _generalised_iou(boxes, target)) * share).sum()


def corners(distances: Tensor) -> Tensor:
    """Convert logarithms of the distances to the edges in cells, (n, 4, h, w), to x1, y1, x2, y2 in px."""
    h, w = distances.shape[2:]
    away = torch.exp(distances.clamp(max=5)) * STRIDE
    x = ((torch.arange(w) + 0.5) * STRIDE).expand(h, w)
    y = ((torch.arange(h) + 0.5) * STRIDE)[:, None].expand(h, w)
    return torch.stack([x - away[:, 0], y - away[:, 1], x + away[:, 2], y + away[:, 3]], dim=1)


def _generalised_iou(a: Tensor, b: Tensor) -> Tensor:
    low, high = torch.maximum(a[:, :2], b[:, :2]), torch.minimum(a[:, 2:], b[:, 2:])
    common = (high - low).clamp(min=0).prod(dim=1)
    both = (a[:, 2:] - a[:, :2]).prod(dim=1) + (b[:, 2:] - b[:, :2]).prod(dim=1) - common
    hull = (torch.maximum(a[:, 2:], b[:, 2:]) - torch.minimum(a[:, :2], b[:, :2])).prod(dim=1)
    return common / both - (hull - both) / hull
