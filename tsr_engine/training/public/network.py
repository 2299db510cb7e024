"""Trains the network that classifies signs; needs PyTorch.

A teacher of twice the width and with more layers learns to distinguish the 43 signs of GTSRB and the drawn signs of
``vienna``. The network then learns from the same views, mostly from the teacher's output for each. Its last
layer becomes the classifier's machines: shifted and scaled so that a sign has a margin of 1 and the others -1 on
average, which a softmax with its own temperature ignores and a retraining needs.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from tsr_engine.errors import UsageError
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.classes import default_keys
from tsr_engine.labels.files import DEFAULT, shipped_set
from tsr_engine.recognition.gtsrb_classes import CLASSES_AFTER_HALF_TURN
from tsr_engine.recognition.network import FEATURES, LAYERS, MIN_SPREAD, Layer, NetworkMap
from tsr_engine.training.progress import Progress
from tsr_engine.training.public.network_crops import CropBank, network_keys
from tsr_engine.training.synthetic.classifier_augmentation import ROUND, view_strength
from tsr_engine.training.synthetic.network_augmentation import views

__all__ = ["NetworkPlan", "Stage", "fit_network", "require_device"]

_TEACHER: Final = (
    Layer(3, 48, 5, 2),
    Layer(48, 48, 3, 1, is_residual=True),
    Layer(48, 96, 3, 2),
    Layer(96, 96, 3, 1, is_residual=True),
    Layer(96, 96, 3, 1, is_residual=True),
    Layer(96, 192, 3, 2),
    Layer(192, 192, 3, 1, is_residual=True),
    Layer(192, 192, 3, 1, is_residual=True),
    Layer(192, 256, 3, 2),
)
_TEACHER_FEATURES: Final = 512
_FACING: Final = ("road-works", "pedestrians", "children", "cyclists-crossing", "wild-animals")
"""Labels with figures that face the other way in other countries."""
_OTHER_WAY: Final = 0.2
"""Probability of mirroring these."""


@dataclass(frozen=True, slots=True)
class Stage:
    """Length and strength of the training of teacher or network.

    Attributes:
        steps: gradient steps.
        rate: peak step size of AdamW, with warm-up and cosine decay to 0.
        drop: share of features dropped in a step.
    """

    steps: int
    rate: float
    drop: float


@dataclass(frozen=True, slots=True)
class NetworkPlan:
    """Settings of the network's training.

    Attributes:
        teacher: stage of the teacher.
        network: stage of the network.
        batch: views per step, a multiple of 16.
        pool: number of batches that are made at once.
        showings: number of times that a view is shown.
        warm_up: share of a stage's steps over which the step size rises.
        decay: weight decay.
        smooth: share of each label that is spread over all labels.
        teacher_weight: weight of the teacher's answers in the network's loss; the labels have the rest.
        softness: temperature at which the answers of both are compared.
        average: share of the averaged weights that is kept in a step.
        calm: share of a stage's steps, at the end, over which the views' strength falls from 1 to ``calm_strength``.
        calm_strength: strength of the last views.
    """

    teacher: Stage = Stage(5800, 2e-3, 0.4)
    network: Stage = Stage(10800, 3e-3, 0.2)
    batch: int = 896
    pool: int = 4
    showings: int = 2
    warm_up: float = 0.05
    decay: float = 0.05
    smooth: float = 0.05
    teacher_weight: float = 0.7
    softness: float = 2.0
    average: float = 0.9985
    calm: float = 0.3
    calm_strength: float = 0.5

    def rate(self, stage: Stage, done: float) -> float:
        """Step size when a share of the steps is done."""
        return stage.rate * min(1.0, done / self.warm_up + 1e-3) * 0.5 * (1 + math.cos(math.pi * done))

    def as_dict(self) -> JsonObject:
        """Plain values for the manifest."""
        return asdict(self)


class _Network(nn.Module):
    """Layers with batch normalisation, then features and output."""

    def __init__(self, layers: Sequence[Layer], features: int, drop: float) -> None:
        super().__init__()
        self.layers = tuple(layers)
        self.convolutions = nn.ModuleList(
            nn.Conv2d(layer.inputs, layer.outputs, layer.size, layer.stride, layer.reach, bias=False)
            for layer in layers
        )
        self.norms = nn.ModuleList(nn.BatchNorm2d(layer.outputs) for layer in layers)
        self.last = nn.Linear(9 * layers[-1].outputs, features, bias=False)
        self.last_norm = nn.BatchNorm1d(features)
        self.drop = nn.Dropout(drop)
        self.answer = nn.Linear(features, len(network_keys()))

    def features(self, x: Tensor) -> Tensor:
        """Map views (n, 3, 48, 48), grey levels, to features."""
        x = x - x.mean((1, 2, 3), keepdim=True)
        x = x / x.square().mean((1, 2, 3), keepdim=True).sqrt().clamp(min=MIN_SPREAD)
        for layer, convolution, norm in zip(self.layers, self.convolutions, self.norms, strict=True):
            found = norm(convolution(x))
            x = torch.relu(found + x if layer.is_residual else found)
        return torch.relu(self.last_norm(self.last(x.permute(0, 2, 3, 1).flatten(1))))

    def forward(self, x: Tensor) -> Tensor:
        """Map views to outputs, shape (n, labels)."""
        return self.answer(self.drop(self.features(x)))

    def exported(self) -> NetworkMap:
        """The weights with folded normalisation, rounded as stored."""
        kernels, biases = [], []
        for convolution, norm in zip(self.convolutions, self.norms, strict=True):
            gain, bias = _folded(norm)
            kernels.append(_rounded(convolution.weight.permute(2, 3, 1, 0).flatten(0, 2) * gain))
            biases.append(_plain(bias))
        gain, bias = _folded(self.last_norm)
        kernels.append(_rounded(self.last.weight.T * gain))
        biases.append(_plain(bias))
        return NetworkMap(tuple(kernels), tuple(biases))


def require_device(device: str) -> None:
    """Refuse a device that PyTorch cannot use here.

    Raises:
        UsageError: gives PyTorch's reason.
    """
    try:
        torch.empty(1, device=device)
    except (RuntimeError, AssertionError) as error:
        reason = str(error).splitlines()[0]
        raise UsageError(f"PyTorch cannot use --device {device} here: {reason} Choose cpu or cuda.") from None


def fit_network(
    bank: CropBank, plan: NetworkPlan, seed: int, device: str, progress: Progress
) -> tuple[NetworkMap, NDArray[np.float32], NDArray[np.float32]]:
    """Train a teacher and then the network.

    Args:
        bank: the crops.
        plan: the settings.
        seed: seed of weights and views.
        device: as PyTorch names it, ``cpu`` or ``cuda``.
        progress: called with stage, number done and total.

    Returns:
        The features, and weights (256, 43) and bias (43,) of the outputs for the signs of GTSRB.
    """
    shown = _Shown(bank, plan, device, seed)
    teacher = _fit(_TEACHER, _TEACHER_FEATURES, plan.teacher, plan, shown, None, _stage_of("teacher", progress))
    network = _fit(LAYERS[:-1], FEATURES, plan.network, plan, shown, teacher, _stage_of("network", progress))
    known = len(default_keys())
    return network.exported(), _plain(network.answer.weight[:known].T), _plain(network.answer.bias[:known])


def _fit(
    layers: Sequence[Layer],
    features: int,
    stage: Stage,
    plan: NetworkPlan,
    shown: _Shown,
    teacher: _Network | None,
    progress: Callable[[int, int], None],
) -> _Network:
    """Train a network; return it with averaged weights."""
    torch.manual_seed(shown.seed)
    device = shown.device
    network = _Network(layers, features, stage.drop).to(device, memory_format=torch.channels_last)
    average: _Network = copy.deepcopy(network).eval()
    optimizer = torch.optim.AdamW(_groups(network, plan), lr=stage.rate)
    for step, (pictures, labels) in zip(range(stage.steps), shown.batches(stage.steps), strict=False):
        for group in optimizer.param_groups:
            group["lr"] = plan.rate(stage, step / stage.steps)
        with torch.autocast(device.split(":", maxsplit=1)[0], torch.bfloat16, enabled=device != "cpu"):
            answers = network(pictures).float()
        loss = functional.cross_entropy(answers, labels, label_smoothing=plan.smooth)
        if teacher is not None:
            with torch.no_grad():
                taught = functional.log_softmax(teacher(pictures) / plan.softness, 1)
            own = functional.log_softmax(answers / plan.softness, 1)
            apart = functional.kl_div(own, taught, log_target=True, reduction="batchmean")
            loss = (1 - plan.teacher_weight) * loss + plan.teacher_weight * plan.softness**2 * apart
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        optimizer.step()
        kept = min(plan.average, (1 + step) / (10 + step))
        with torch.no_grad():
            for mean, now in zip(_floats(average), _floats(network), strict=True):
                mean.lerp_(now, 1 - kept)
        if step % 25 == 24 or step == stage.steps - 1:
            progress(step + 1, stage.steps)
    return average


def _floats(network: _Network) -> list[Tensor]:
    return [value for value in network.state_dict().values() if value.is_floating_point()]


def _groups(network: _Network, plan: NetworkPlan) -> list[JsonObject]:
    """Parameter groups: matrices and kernels decay, gains and biases do not."""
    weights = list(network.parameters())
    return [
        {"params": [w for w in weights if w.ndim > 1], "weight_decay": plan.decay},
        {"params": [w for w in weights if w.ndim == 1], "weight_decay": 0.0},
    ]


def _folded(norm: Any) -> tuple[Tensor, Tensor]:  # Any: PyTorch types its statistics as optional
    gain = norm.weight / (norm.running_var + norm.eps).sqrt()
    return gain, norm.bias - norm.running_mean * gain


def _plain(values: Tensor) -> NDArray[np.float32]:
    return np.ascontiguousarray(values.detach().float().cpu().numpy())


def _rounded(matrix: Tensor) -> NDArray[np.float32]:
    return np.ascontiguousarray(_plain(matrix).astype(np.float16).astype(np.float32))


def _stage_of(what: str, progress: Progress) -> Callable[[int, int], None]:
    return lambda done, total: progress(what, done, total)


class _Shown:
    """Views with their labels; all crops are on the device."""

    def __init__(self, bank: CropBank, plan: NetworkPlan, device: str, seed: int) -> None:
        self.device, self.seed, self._plan = device, seed, plan
        self._generator = torch.Generator(device).manual_seed(seed)
        self._pixels, self._boxes = torch.from_numpy(bank.pixels).to(device), torch.from_numpy(bank.boxes).to(device)
        self._classes, self._bends = torch.from_numpy(bank.classes).to(device), torch.from_numpy(bank.bends).to(device)
        self._until = torch.from_numpy(np.cumsum(bank.chances)).to(device)
        count = len(network_keys())
        mirrored, half_turned = np.full(count, -1), np.full(count, -1)
        for label, other in shipped_set(DEFAULT).mirror_images().items():
            mirrored[label] = other
        for label, other in CLASSES_AFTER_HALF_TURN:
            half_turned[label] = other
        often = np.where(mirrored >= 0, 0.5, 0.0)
        for key in _FACING:
            number = default_keys().index(key)
            mirrored[number], often[number] = number, _OTHER_WAY
        self._round = torch.tensor([number in ROUND for number in range(count)], device=device)
        self._often = torch.from_numpy(often.astype(np.float32)).to(device)
        self._mirror, self._half = torch.from_numpy(mirrored).to(device), torch.from_numpy(half_turned).to(device)

    def batches(self, steps: int) -> Iterator[tuple[Tensor, Tensor]]:
        """Yield views and labels of each step."""
        plan = self._plan
        for first in range(0, steps, plan.pool * plan.showings):
            strength = view_strength(first / steps, plan.calm, plan.calm_strength)
            pictures, labels = self._views(plan.batch * plan.pool, strength)
            for _ in range(plan.showings):
                order = torch.randperm(len(labels), generator=self._generator, device=self.device)
                for rows in order.chunk(plan.pool):
                    yield pictures[rows].contiguous(memory_format=torch.channels_last), labels[rows]

    def _views(self, count: int, strength: float) -> tuple[Tensor, Tensor]:
        """Views and their labels, which mirroring and rotation may change."""

        def share() -> Tensor:
            return torch.rand(count, generator=self._generator, device=self.device)

        chosen = torch.searchsorted(self._until, share().double() * self._until[-1]).clamp(max=len(self._until) - 1)
        labels = self._classes[chosen]
        half = (self._half[labels] >= 0) & (share() < 0.5)
        turns = torch.where(self._round[labels], 2 * torch.pi * share(), torch.where(half, torch.pi, 0.0))
        pictures = views(
            self._pixels[chosen], self._boxes[chosen], self._bends[chosen], turns, self._generator, strength
        )
        labels = torch.where(half, self._half[labels], labels)
        mirrored = share() < self._often[labels]
        pictures = torch.where(mirrored[:, None, None, None], pictures.flip(3), pictures)
        return pictures, torch.where(mirrored, self._mirror[labels], labels)
