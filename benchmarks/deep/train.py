"""Train the small deep detector on the scenes that the ACF detector of the report was trained on, one CPU core.

    python -m benchmarks.deep.train --gtsdb GTSDB --state out/deep.pt --out benchmarks/deep/signs.onnx

With --minutes it saves its state and ends after that time; the same command continues. Needs `torch` and `onnx`.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import torch
from torch import Tensor, nn

from benchmarks.deep.crops import SIDE, Crop, HardNegatives, background, cut, on_sign, targets
from benchmarks.deep.loss import loss
from benchmarks.deep.network import SignNetwork
from benchmarks.deep.onnx_file import write_network
from tsr_engine.io.gtsdb import Scene, read_gtsdb
from tsr_engine.io.pictures import read_picture
from tsr_engine.json_shapes import JsonObject
from tsr_engine.records import Picture
from tsr_engine.training.public.detector_components import split_scenes

BATCH = 16
SIGNS = 11
"""Number of crops of a batch around signs; the others are background."""
RATE, DECAY = 3e-3, 1e-4
AVERAGE = 0.99
"""Decay of the running mean of the weights, which is written."""


@dataclass(slots=True)
class Training:
    """The state of a training, from which it can continue."""

    network: nn.Module
    average: dict[str, Tensor]
    optimiser: torch.optim.Optimizer
    hard: HardNegatives
    step: int = 0
    cpu_seconds: float = 0.0

    @classmethod
    def start(cls, seed: int) -> Training:
        """A new state with random weights."""
        torch.manual_seed(seed)
        network = SignNetwork().to(memory_format=torch.channels_last)
        optimiser = torch.optim.AdamW(network.parameters(), lr=RATE, weight_decay=DECAY)
        return cls(network, {k: v.clone() for k, v in network.state_dict().items()}, optimiser, HardNegatives())

    def save(self, path: Path, settings: JsonObject) -> None:
        """Write the state."""
        path.parent.mkdir(parents=True, exist_ok=True)
        parts = (self.network.state_dict(), self.average, self.optimiser.state_dict())
        part = path.with_suffix(".part")
        torch.save((parts, self.hard.places, self.step, self.cpu_seconds, settings), part)
        part.replace(path)  # a kill during the write keeps the old state

    def load(self, path: Path, settings: JsonObject) -> None:
        """Load a state; only the number of steps may differ, and the learning rate then falls to the new end.

        Raises:
            SystemExit: the state belongs to a training with other settings.
        """
        parts, self.hard.places, self.step, self.cpu_seconds, before = torch.load(path, weights_only=True)
        if before | {"steps": 0} != settings | {"steps": 0}:
            raise SystemExit(
                f"{path} belongs to a training with {before}, expected {settings}. Remove it or choose another file."
            )
        self.network.load_state_dict(parts[0])
        self.average = parts[1]
        self.optimiser.load_state_dict(parts[2])


def rate_at(step: int, steps: int) -> float:
    """Learning rate: it rises over the first twentieth of the steps, then falls along a cosine."""
    up = max(1, steps // 20)
    return float(RATE * (min(1.0, (step + 1) / up) * 0.5 * (1 + np.cos(np.pi * step / steps)) + 1e-3))


def draw(
    rng: np.random.Generator, pictures: Sequence[Picture], scenes: Sequence[Scene], hard: HardNegatives
) -> list[tuple[int, Crop]]:
    """Draw the crops of a batch; returns each with the number of its scene."""
    signs = [(number, box) for number, scene in enumerate(scenes) for box in scene.boxes]
    crops = []
    for slot in range(BATCH):
        if slot < SIGNS:
            number, box = signs[int(rng.integers(len(signs)))]
            place = on_sign(rng, box)
        else:
            known = hard.pop(rng) if slot % 2 else None
            number = int(rng.integers(len(scenes))) if known is None else known[0]
            height, width = pictures[number].shape[:2]
            place = background(rng, width, height, None if known is None else known[1:])
        crops.append((number, cut(rng, pictures[number], scenes[number].boxes, *place)))
    return crops


def advance(state: Training, crops: Sequence[tuple[int, Crop]], rate: float) -> float:
    """Do one training step; returns the loss."""
    pixels = np.stack([crop.picture[..., ::-1] for _, crop in crops])
    x = torch.from_numpy(pixels).permute(0, 3, 1, 2).float().div(255).contiguous(memory_format=torch.channels_last)
    heatmap, edges, weights = (torch.from_numpy(np.stack(v)) for v in zip(*(targets(c) for _, c in crops), strict=True))
    for group in state.optimiser.param_groups:
        group["lr"] = rate
    answer = state.network(x)
    value = loss(answer, heatmap, edges, weights)
    state.optimiser.zero_grad(set_to_none=True)
    value.backward()
    nn.utils.clip_grad_norm_(state.network.parameters(), 10.0)
    state.optimiser.step()
    state.step += 1
    keep = min(AVERAGE, (state.step + 1) / (state.step + 10))
    for name, now in state.network.state_dict().items():
        before = state.average[name]
        before.copy_(before * keep + now * (1 - keep) if before.is_floating_point() else now)
    surest = torch.where(heatmap == 0, answer[:, 0].detach(), -20.0).amax(dim=(1, 2))
    for slot in range(SIGNS, len(crops)):
        number, crop = crops[slot]
        if not len(crop.boxes):
            state.hard.add(float(surest[slot]), number, *crop.place)
    return float(value.detach())


def main() -> None:
    """Train or continue training, and write the trained network."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gtsdb", type=Path, required=True)
    parser.add_argument("--state", type=Path, required=True, help="file of the training's state")
    parser.add_argument("--out", type=Path, required=True, help="the ONNX file; a .json is written as well")
    parser.add_argument("--steps", type=int, default=700)
    parser.add_argument("--minutes", type=float, default=1e9, help="save the state and stop after this time")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    began = time.monotonic()
    scenes, _, _ = split_scenes(read_gtsdb(args.gtsdb), args.seed)
    pictures = [read_picture(scene.path) for scene in scenes]
    settings = {"steps": args.steps, "seed": args.seed, "scenes": len(scenes), "batch": BATCH, "crop": SIDE}
    state = Training.start(args.seed)
    if args.state.is_file():
        state.load(args.state, settings)
    state.network.train()
    mean = 0.0
    while state.step < args.steps and time.monotonic() - began < 60 * args.minutes:
        clock = time.process_time()
        rng = np.random.default_rng([args.seed, 47, state.step])
        value = advance(state, draw(rng, pictures, scenes, state.hard), rate_at(state.step, args.steps))
        state.cpu_seconds += time.process_time() - clock
        mean = value if state.step == 1 else 0.97 * mean + 0.03 * value
        if state.step % 20 == 0:
            minutes = state.cpu_seconds / 60
            sys.stderr.write(f"step {state.step} of {args.steps}, loss {mean:.3f}, {minutes:.1f} min of CPU\n")
        if state.step % 50 == 0:
            state.save(args.state, settings)
    state.save(args.state, settings)
    if state.step < args.steps:
        sys.stderr.write(f"Stopped at step {state.step}; the same command goes on.\n")
        return
    signs = sum(len(scene.boxes) for scene in scenes)
    budget = {
        **settings,
        "signs": signs,
        "crops": args.steps * BATCH,
        "views_of_each_sign": round(args.steps * SIGNS / signs, 1),
        "cpu_minutes": round(state.cpu_seconds / 60, 1),
        "parameters": sum(p.numel() for p in state.network.parameters()),
        "torch": torch.__version__,
    }
    weights = {name: value.numpy() for name, value in state.average.items()}
    write_network(args.out, weights, budget)


if __name__ == "__main__":
    main()
