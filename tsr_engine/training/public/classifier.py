"""Trains the sign classifier from GTSRB class folders."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import InputError
from tsr_engine.io.gtsrb import CropItem, read_items, split_by_track
from tsr_engine.io.models import Component
from tsr_engine.recognition.classifier import COMPONENT, GEOMETRY, SignClassifier
from tsr_engine.recognition.descriptor import LENGTH, SIDE, describe_patches
from tsr_engine.recognition.gtsrb_classes import CLASS_COUNT
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.progress import Progress
from tsr_engine.training.public.classifier_figures import held_out_figures
from tsr_engine.training.public.classifier_network import Network, NetworkSettings, Wanted
from tsr_engine.training.synthetic.classifier_augmentation import LoadedCrop, jittered_view, load_crop, view_strength
from tsr_engine.training.synthetic.drawn_signs import drawn_crops
from tsr_engine.training.synthetic.inset_signs import inset_crops

_REFIT_RATE = 0.4
"""Peak step size of training on all tracks, relative to that on the split."""
_RECENT = 32
"""Number of batches kept for a second showing."""


@dataclass(frozen=True, slots=True)
class ClassifierSettings:
    """Settings of the classifier's training."""

    steps: int = 7000
    """Gradient steps on the training part of the split."""
    refit_steps: int = 1000
    """Further gradient steps on all tracks, from the weights of the split; 0: keep the weights of the split."""
    batch: int = 128
    """Views per step."""
    showings: int = 2
    """Average number of showings of a view; making a view costs as much as learning from it."""
    held_out: float = 0.25
    """Share of each class's tracks for figures and temperature."""
    balance: float = 0.7
    """Exponent of class sizes in the draw of pictures: 1: proportional, 0: all classes equally often."""
    drawn: float = 0.10
    """Share of views that are drawn in the style of other countries (``synthetic.drawn_signs``)."""
    drawn_crops: int = 120
    """Drawn crops of each class with a drawing."""
    inset: float = 0.06
    """Share of views of real speed limits with smaller digits (``synthetic.inset_signs``)."""
    inset_crops: int = 150
    """Crops with smaller digits of each limit."""
    calm: float = 0.3
    """Share of the steps, at the end, over which the views' strength falls from 1 to ``calm_strength``."""
    calm_strength: float = 0.5
    network: NetworkSettings = field(default_factory=NetworkSettings)


def train_classifier(
    folder: Path, seed: int = 0, settings: ClassifierSettings | None = None, progress: Progress | None = None
) -> Component:
    """Train on GTSRB class folders; the same seed, data and library versions give the same component.

    A part of the tracks is first held out for the figures and the temperature. Training then continues on all tracks.
    So the figures are of weights that have seen fewer tracks than the returned ones.

    Args:
        folder: folder of the class folders 00000 to 00042.
        seed: seed of split, weights and views.
        settings: unset: as shipped.
        progress: called as the work proceeds.

    Returns:
        The component ``classifier``.

    Raises:
        InputError: missing or damaged data, or a class without pictures.
    """
    settings = settings or ClassifierSettings()
    progress = progress or (lambda stage, done, total: None)
    items = [item for item in read_items(folder) if item.track is not None]
    require_all_classes(items, folder)
    training, held = split_by_track(items, settings.held_out, seed)
    crops = load_all(training, progress, "read training pictures")
    held_crops = load_all(held, progress, "read held-out pictures")
    component = train_on_split(crops, held_crops, settings, seed, progress)
    figures = component.figures
    if settings.refit_steps:
        arrays = refit_arrays(component.arrays, crops + held_crops, settings, seed, progress, "train on all tracks")
        component = _component(arrays, float(component.params["temperature"]))
    return replace(
        component,
        data={
            "name": "GTSRB training set",
            "pictures": len(items),
            "tracks": len({item.track for item in items}),
            "weights_from": "all tracks" if settings.refit_steps else "training part of the split",
            "figures_from": "held-out tracks of the split, weights of its training part",
            "held_out_tracks": len({item.track for item in held}),
        },
        figures=figures,
        seed=seed,
        params={**component.params, "training": asdict(settings)},
    )


def train_on_split(
    crops: Sequence[LoadedCrop],
    held: Sequence[LoadedCrop],
    settings: ClassifierSettings,
    seed: int,
    progress: Progress | None = None,
) -> Component:
    """Train on some tracks; the others give temperature and figures.

    Args:
        crops: what is learned.
        held: crops of other tracks.
        settings: ``held_out`` and ``refit_steps`` are not used.
        seed: of weights and views.
        progress: called as the work proceeds.
    """
    arrays = fit_arrays(crops, settings, seed, progress or (lambda stage, done, total: None), "train on the split")
    trial = SignClassifier.from_component(_component(arrays, 1.0))
    temperature, figures = held_out_figures(trial, held, seed)
    return replace(_component(arrays, temperature), figures=figures, seed=seed)


def require_all_classes(items: Sequence[CropItem], folder: Path) -> None:
    """Refuse crops that lack a class.

    Raises:
        InputError: which classes.
    """
    missing = sorted(set(range(CLASS_COUNT)) - {item.class_id for item in items if item.class_id is not None})
    if missing:
        raise InputError(
            f"Expected training tracks of all {CLASS_COUNT} classes in {folder}, found none of class "
            f"{', '.join(map(str, missing))}. Use the whole GTSRB training set."
        )


def load_all(items: Sequence[CropItem], progress: Progress, stage: str) -> list[LoadedCrop]:
    """Decode items into memory (about 8 KB each).

    Raises:
        InputError: an unreadable picture.
    """
    crops = []
    for i, item in enumerate(items):
        crops.append(load_crop(item))
        if i % 500 == 499 or i == len(items) - 1:
            progress(stage, i + 1, len(items))
    return crops


def fit_arrays(
    crops: Sequence[LoadedCrop],
    settings: ClassifierSettings,
    seed: int,
    progress: Progress,
    stage: str,
    unseen: Container[int] = (),
) -> dict[str, NDArray[np.generic]]:
    """Train the weights; matrices come back as float16, which is how they are stored and used.

    No drawing, no mirror image and no turned one shows a class of ``unseen``; ``crops`` must have none of them.
    """
    network = Network(settings.network, seed)
    views = _views(crops, settings, settings.steps, np.random.default_rng([seed, 1]), unseen)
    return descend(network, views, settings.steps, progress, stage)


def refit_arrays(
    arrays: Mapping[str, NDArray[np.generic]],
    crops: Sequence[LoadedCrop],
    settings: ClassifierSettings,
    seed: int,
    progress: Progress,
    stage: str,
) -> dict[str, NDArray[np.generic]]:
    """Train on from given weights, at a reduced rate, on other pictures."""
    network = Network(replace(settings.network, rate=settings.network.rate * _REFIT_RATE), seed + 1)
    network.resume(arrays)
    views = _views(crops, settings, settings.refit_steps, np.random.default_rng([seed, 3]))
    return descend(network, views, settings.refit_steps, progress, stage)


def descend(
    network: Network,
    views: Iterator[tuple[NDArray[np.float32], Wanted]],
    steps: int,
    progress: Progress,
    stage: str,
) -> dict[str, NDArray[np.generic]]:
    """Take the steps; the average of the last weights, matrices as float16, which is how they are stored and used."""
    for step in range(steps):
        descriptors, labels = next(views)
        network.train_step(descriptors, labels, step / steps)
        if step % 25 == 24 or step == steps - 1:
            progress(stage, step + 1, steps)
    half = {"filters", "hidden", "weights"}
    return {key: value.astype(np.float16 if key in half else np.float32) for key, value in network.average.items()}


def _views(
    crops: Sequence[LoadedCrop],
    settings: ClassifierSettings,
    steps: int,
    generator: np.random.Generator,
    unseen: Container[int] = (),
) -> Iterator[tuple[NDArray[np.float32], NDArray[np.int64]]]:
    """Endless batches of descriptors and labels: new views, and between them views drawn from the latest ones."""
    classes = np.array([crop.class_id for crop in crops])
    counts = np.bincount(classes, minlength=CLASS_COUNT).astype(np.float64)
    chance = counts[classes] ** (settings.balance - 1)
    chance /= chance.sum()
    drawn = drawn_crops(settings.drawn_crops, generator) if settings.drawn > 0 else []
    drawn = [crop for crop in drawn if crop.class_id not in unseen]
    inset = inset_crops(crops, settings.inset_crops, generator) if settings.inset > 0 else []
    for share, others in ((settings.drawn, drawn), (settings.inset, inset)):
        if others:
            crops = [*crops, *others]
            chance = np.concatenate([chance * (1 - share), np.full(len(others), share / len(others))])
    yield from shown_views(
        crops, chance, settings.batch, settings.showings, generator,
        lambda made: view_strength(made * settings.showings / steps, settings.calm, settings.calm_strength),
        partial(jittered_view, unseen=unseen),
    )  # fmt: skip


def shown_views(
    crops: Sequence[LoadedCrop],
    chance: NDArray[np.float64],
    batch: int,
    showings: int,
    generator: np.random.Generator,
    strength: Callable[[int], float],
    view: Callable[[LoadedCrop, np.random.Generator, float], tuple[Picture, int | FloatArray]] = jittered_view,
) -> Iterator[tuple[NDArray[np.float32], Wanted]]:
    """Endless batches of views of crops, each view shown several times on average.

    Args:
        crops: what is viewed.
        chance: shape (crops,): how likely each is drawn; sums to 1.
        batch: views a batch.
        showings: batches made of recent views for each batch of new ones, that one included.
        generator: of all draws.
        strength: of the views, given the number of batches of new views so far.
        view: makes a view of a crop and its target: a class, or numbers.

    Yields:
        Descriptors (batch, 4320) and what is to be learned of them, (batch,) or (batch, k).
    """
    patches = np.empty((batch, SIDE, SIDE, 3), dtype=np.uint8)
    descriptors = np.empty((_RECENT * batch, LENGTH), dtype=np.float32)
    labels = np.empty(0)
    made = 0
    while True:
        now = strength(made)
        new = slice(made % _RECENT * batch, (made % _RECENT + 1) * batch)
        reported = []
        for row, index in enumerate(generator.choice(len(crops), batch, p=chance)):
            patches[row], label = view(crops[index], generator, now)
            reported.append(label)
        if not made:
            labels = np.empty((len(descriptors), *np.shape(reported[0])), dtype=np.result_type(*reported))
        labels[new] = reported
        descriptors[new] = describe_patches(patches)
        made += 1
        yield descriptors[new], labels[new]
        for _ in range(showings - 1):
            again = generator.integers(0, min(made, _RECENT) * batch, batch)
            yield descriptors[again], labels[again]


def _component(arrays: dict[str, NDArray[np.generic]], temperature: float) -> Component:
    return Component(COMPONENT, arrays, {**GEOMETRY, "temperature": temperature, "paired": True})
