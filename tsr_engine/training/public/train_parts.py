"""Trains models on public data, part by part, into one folder; existing parts are kept."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from tsr_engine.detection.acf import AcfModel
from tsr_engine.detection.other_shapes import COMPONENT as OTHER_SHAPES
from tsr_engine.errors import UsageError
from tsr_engine.io.gtsdb import read_gtsdb
from tsr_engine.io.gtsrb import read_items
from tsr_engine.io.models import MANIFEST, SHIPPED, Component, load_component, read_manifest, save_component
from tsr_engine.json_shapes import JsonObject
from tsr_engine.recognition.classifier import NETWORK_COMPONENT, SignClassifier
from tsr_engine.training.progress import Progress, named
from tsr_engine.training.public.classifier import train_classifier
from tsr_engine.training.public.detector_components import train_detector, train_prior
from tsr_engine.training.public.gtsdb_signs import ignoring, other_signs, read_signs
from tsr_engine.training.public.memory import COMPONENT as MEMORY
from tsr_engine.training.public.memory import build_memory
from tsr_engine.training.public.online_samples import train_online
from tsr_engine.training.public.other_shapes import train_other_shapes
from tsr_engine.training.report import Report

__all__ = ["COMPONENTS", "train_component", "train_parts"]

COMPONENTS: Final = ("detector", "prior", "classifier", "online", MEMORY, OTHER_SHAPES)
"""Components trained on public data, in this order."""
_NEEDS: Final = {
    "classifier": ("--gtsrb DIR",),
    MEMORY: ("--gtsdb DIR", "--gtsrb DIR"),
    OTHER_SHAPES: ("--gtsdb DIR", "--signs FILE"),
}
"""Component -> options that name its data; the others need scenes only."""
_BUILDS_ON: Final = {"prior": ("detector",), MEMORY: ("detector", "classifier"), OTHER_SHAPES: ("detector",)}
"""Component -> components that its training needs in the same folder."""


def train_component(
    name: str,
    out: Path,
    seed: int,
    progress: Progress,
    gtsdb: Path | None,
    gtsrb: Path | None,
    signs: Path | None = None,
) -> Component:
    """Train one component on public data.

    Args:
        name: a name in ``COMPONENTS``.
        out: folder of components that it needs: prior and detector of other shapes need the detector, the memory needs
            detector and classifier.
        seed: seed of all randomness.
        progress: called with stage, number done and total.
        gtsdb: annotated scenes.
        gtsrb: crops.
        signs: annotations of other signs in the scenes, which are then not background; None: no annotations.

    Raises:
        UsageError: required data is not named, or a component that this one needs is missing.
        InputError: the data cannot be read.
    """
    named_data = {"--gtsdb DIR": gtsdb, "--gtsrb DIR": gtsrb, "--signs FILE": signs}
    needs = _NEEDS.get(name, ("--gtsdb DIR",))
    if name not in COMPONENTS or any(named_data[option] is None for option in needs):
        raise UsageError(f"Training {_shown(name)} needs {' and '.join(needs)}. Name the unpacked data.")
    present = set(read_manifest(out)["components"]) if (out / MANIFEST).exists() else set()
    for missing in (part for part in _BUILDS_ON.get(name, ()) if part not in present):
        raise UsageError(f"Training {_shown(name)} needs the {missing}, which {out} lacks. Train it there first.")
    if name == "classifier":
        return train_classifier(gtsrb or Path(), seed, progress=progress)
    scenes = read_gtsdb(gtsdb or Path())
    annotations = None if signs is None else read_signs(signs)
    if name == OTHER_SHAPES and annotations is not None:
        return train_other_shapes(other_signs(scenes, annotations), load_component("detector", out), seed, progress)
    if annotations is not None:
        scenes = ignoring(scenes, annotations)
    if name == "detector":
        return train_detector(scenes, gtsrb, seed, progress)
    if name == "prior":
        return train_prior(scenes, load_component("detector", out), seed, progress)
    if name == "online":
        return train_online(scenes, seed)
    detector, classifier = load_component("detector", out), load_component("classifier", out)
    return build_memory(
        scenes,
        [item for item in read_items(gtsrb or Path()) if item.track is not None],
        AcfModel.from_arrays(detector.arrays, detector.params),
        SignClassifier.from_component(classifier),
        seed,
        progress,
    )


def _shown(name: str) -> str:
    """The component's name as a command."""
    return name.replace("_", "-")


def train_parts(
    parts: Sequence[str],
    parent: Path | None,
    out: Path,
    seed: int,
    progress: Progress,
    *,
    gtsdb: Path | None = None,
    gtsrb: Path | None = None,
) -> Report:
    """Train parts on public data; the others are copied from a parent.

    Parts that an interrupted call has finished in ``out`` are kept. The memory is rebuilt if detector or
    classifier are, if the data for it is named.

    Args:
        parts: names in ``tsr_engine.training.corrections.retrain.PARTS``.
        parent: folder of the earlier version; unset: the shipped one.
        out: folder for the new one.
        seed: seed of all randomness.
        progress: called with stage, number done and total; may raise to stop.
        gtsdb: annotated scenes.
        gtsrb: crops.

    Raises:
        UsageError: data for a part is not named.
        InputError: the data cannot be read.
    """
    folder = SHIPPED if parent is None else parent
    old = {name: load_component(name, folder) for name in sorted(read_manifest(folder)["components"])}
    requested = {"prior" if name == "lambda" else name for name in parts}
    if "detector" in requested:
        requested.add("prior")  # lambda depends on the scale of the detector's score
    if requested & {"detector", "classifier"} and gtsdb is not None and gtsrb is not None:
        requested.add(MEMORY)
    for name in requested:
        if name in COMPONENTS and (
            (name == "classifier" and gtsrb is None) or (name != "classifier" and gtsdb is None)
        ):
            raise UsageError(f"Training {name} needs {'gtsrb' if name == 'classifier' else 'gtsdb'}. Name its folder.")
    done: set[str] = set(read_manifest(out)["components"]) if (out / MANIFEST).exists() else set()
    figures: JsonObject = {}
    stale = {MEMORY: {"detector", "classifier"}}
    for name in (n for n in (*COMPONENTS, NETWORK_COMPONENT) if n in requested or n in old):
        if name in requested and name not in done:
            component = train_component(name, out, seed, named(name, progress), gtsdb, gtsrb)
            save_component(component, out)
        elif name not in requested and not requested & stale.get(name, set()):
            save_component(replace(old[name]), out)
    models: dict[str, str] = {}
    labels: JsonObject = {}
    for name in sorted(read_manifest(out)["components"]):
        component = load_component(name, out)
        models[name] = component.sha256
        if name == "classifier" and "labels" in component.params:
            labels = {"labels": component.params["labels"]}
        if name in requested and component.figures:
            figures[name] = {"new": dict(component.figures), "parent": dict(old[name].figures) if name in old else {}}
    lineage = {
        "parent": {"folder": None if parent is None else parent.name, "models": {n: c.sha256 for n, c in old.items()}},
        "parts": sorted(requested),
        "seed": seed,
        "exports": [],
        "data": {"gtsdb": None if gtsdb is None else gtsdb.name, "gtsrb": None if gtsrb is None else gtsrb.name},
        **labels,
    }
    return Report(figures, lineage, models)
