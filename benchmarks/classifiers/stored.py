"""Parts of GTSRB's signs, and classifiers that are trained without one of them, once for each scratch folder."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from benchmarks.cache import code
from benchmarks.experiment import Data
from tsr_engine.io.gtsrb import CropItem, folds_by_track, read_items, read_picture
from tsr_engine.io.models import Component, load_component, save_component
from tsr_engine.pipeline import one_blas_thread
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.recognition.crops import cut

FOLDS = 4
"""Number of parts of the signs; each is held out once. The first is the split that `tsr train` reports on."""
TRAINING_CODE = ("io", "recognition", "training")
"""Parts of the engine that a classifier depends on; a change of their code makes stored classifiers invalid."""
TIMED_CROPS = 1000
"""Number of crops to classify one by one, for the time."""


def folds(data: Data) -> list[tuple[list[CropItem], list[CropItem]]]:
    """For each part of the tracks of GTSRB, the crops of all others and its own.

    Raises:
        Skip: there are no crops.
    """
    items = [item for item in read_items(data.need("gtsrb")) if item.track is not None]
    parts = []
    for held in folds_by_track(items, FOLDS, data.seed):
        tracks = {item.track for item in held}
        parts.append(([item for item in items if item.track not in tracks], held))
    return parts


def training_digest(steps: tuple[str, ...], *settings: object) -> str:
    """Short digest of code, see :func:`~benchmarks.cache.code`, and of settings, for the name of a folder."""
    return hashlib.sha256(" ".join(map(str, (code(steps), *settings))).encode()).hexdigest()[:12]


def stored_classifier(folder: Path, name: str, train: Callable[[], Component]) -> SignClassifier:
    """The classifier of a folder; it is trained if the folder has none.

    Args:
        folder: folder of the component.
        name: name of the component.
        train: trains it.
    """
    if not (folder / "manifest.json").is_file():
        save_component(train(), folder)
    return SignClassifier.from_component(load_component(name, folder))


def crop_time(items: Sequence[CropItem], classifier: SignClassifier) -> float:
    """Median CPU time to classify one crop on one thread, from cutting to the class, ms."""
    seconds = []
    with one_blas_thread():
        for item in items[:: max(1, len(items) // TIMED_CROPS)]:
            picture, box = read_picture(item), item.roi
            if box is None:
                continue
            start = time.thread_time()
            classifier.probabilities([cut(picture, box, classifier.margin)])
            seconds.append(time.thread_time() - start)
    return round(1e3 * float(np.median(seconds)), 3)
