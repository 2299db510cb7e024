"""Figures of two versions on public data and on the remembered samples of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from tsr_engine.detection.acf import AcfModel
from tsr_engine.evaluation.classification import predict_items
from tsr_engine.io.gtsdb import Scene, read_gtsdb
from tsr_engine.io.gtsrb import CropItem, read_items, split_by_track
from tsr_engine.io.models import Component
from tsr_engine.json_shapes import JsonObject
from tsr_engine.pipeline import make_reader
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.training.progress import Progress, named
from tsr_engine.training.public.detector_components import detect_scenes, detection_figures, split_scenes
from tsr_engine.training.public.memory import COMPONENT, Samples

__all__ = ["public_figures", "remembered_figures"]


_HELD_OUT_SHARE = 0.25
"""Share of the GTSRB tracks that training held out."""
_CROPS_PER_TRACK = 3
"""Crops of each held-out track: neighbours hardly differ."""


def remembered_figures(parts: Mapping[str, Component]) -> JsonObject:
    """Shares of the remembered training data that a version gets right, in the part that refinements do not use.

    Returns:
        Shares of signs above and of background below log-odds 0, and of crops read right by the classifier
        alone, whose features the memory holds; empty without a memory.
    """
    memory = parts.get(COMPONENT)
    if memory is None:
        return {}
    model = AcfModel.from_arrays(parts["detector"].arrays, parts["detector"].params)
    out: JsonObject = {}
    for name, sign in (("signs", 1.0), ("others", -1.0)):
        samples = Samples.from_arrays(memory.arrays, name)
        unused = samples.select(np.arange(len(samples)) % 3 == 0)
        out[f"{name}_kept"] = round(float((sign * unused.raw(model) > 0).mean()), 4)
    classifier = SignClassifier.from_component(parts["classifier"])
    margins = memory.arrays["crops"].astype(np.float32) @ classifier.weights + classifier.bias
    out["crops_kept"] = round(float((margins.argmax(axis=1) == memory.arrays["classes"]).mean()), 4)
    return out


def public_figures(
    new: Mapping[str, Component],
    old: Mapping[str, Component],
    gtsdb: Path | None,
    gtsrb: Path | None,
    seed: int,
    progress: Progress,
) -> Iterator[tuple[str, JsonObject, JsonObject]]:
    """Name and figures of the new and the earlier version, for each folder that is named.

    The shipped version has learned from all scenes and tracks in the end, so the figures tell what a refinement
    spoils, not how good a version is on new data.

    Raises:
        InputError: a folder cannot be read.
    """
    if gtsdb is not None:
        scenes = split_scenes(read_gtsdb(gtsdb), int(old["detector"].seed or 0))[2]
        yield "gtsdb", _scenes(new, scenes, progress), _scenes(old, scenes, progress)
    if gtsrb is not None:
        items = [item for item in read_items(gtsrb) if item.track is not None and item.class_id is not None]
        held = split_by_track(items, _HELD_OUT_SHARE, int(old["classifier"].seed or 0))[1]
        chosen = held[:: max(1, len(held) // (_CROPS_PER_TRACK * max(1, len({item.track for item in held}))))]
        yield "gtsrb", _crops(new, chosen, progress), _crops(old, chosen, progress)


def _scenes(parts: Mapping[str, Component], scenes: Sequence[Scene], progress: Progress) -> JsonObject:
    model = AcfModel.from_arrays(parts["detector"].arrays, parts["detector"].params)
    return detection_figures(detect_scenes(model, scenes, named("GTSDB", progress)))


def _crops(parts: Mapping[str, Component], items: Sequence[CropItem], progress: Progress) -> JsonObject:
    correct = 0
    for number, answer in enumerate(predict_items(items, make_reader(parts))):
        if number % 64 == 0:
            progress("GTSRB: reading", number, len(items))
        correct += answer.class_id == answer.item.class_id
    return {"crops_right": round(correct / len(items), 4), "crops": len(items)}
