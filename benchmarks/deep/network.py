"""The network in PyTorch, for training; needs `torch`."""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn

from benchmarks.deep.architecture import CONVOLUTIONS

RARE = 0.01
"""Probability of a sign in each cell before training."""


class SignNetwork(nn.Module):
    """Maps pictures (n, 3, h, w), RGB in 0..1, to outputs (n, 5, h / 8, w / 8); see `architecture`."""

    def __init__(self) -> None:
        super().__init__()
        for c in CONVOLUTIONS.values():
            last = c.name == "answer"
            layer = nn.Conv2d(c.inputs, c.outputs, c.size, c.stride, c.size // 2, bias=last)
            nn.init.kaiming_normal_(layer.weight, nonlinearity="relu")
            self.add_module(c.name, layer)
            if not last:
                self.add_module(f"{c.name}_norm", nn.BatchNorm2d(c.outputs))
        answer = self.get_submodule("answer")
        with torch.no_grad():
            answer.weight.mul_(0.1)
            answer.bias.copy_(torch.tensor([-math.log(1 / RARE - 1), 0.7, 0.7, 0.7, 0.7]))

    def _conv(self, name: str, x: Tensor) -> Tensor:
        return self.get_submodule(f"{name}_norm")(self.get_submodule(name)(x))

    def _block(self, name: str, x: Tensor) -> Tensor:
        return torch.relu(x + self._conv(f"{name}_b", torch.relu(self._conv(f"{name}_a", x))))

    def forward(self, x: Tensor) -> Tensor:
        """See the class."""
        x = torch.relu(self._conv("stem", x))
        x = torch.relu(self._conv("at4", torch.relu(self._conv("down4", x))))
        at8 = self._block("at8_again", self._block("at8", torch.relu(self._conv("down8", x))))
        at16 = self._block("at16", torch.relu(self._conv("down16", at8)))
        at32 = torch.relu(self._conv("at32", torch.relu(self._conv("down32", at16))))
        back = torch.relu(self._conv("side16", at16)) + _twice(torch.relu(self._conv("side32", at32)))
        back = torch.relu(self._conv("side8", at8)) + _twice(back)
        back = torch.relu(self._conv("head", torch.relu(self._conv("merge", back))))
        return self.get_submodule("answer")(back)


def _twice(x: Tensor) -> Tensor:
    return nn.functional.interpolate(x, scale_factor=2.0, mode="nearest")
