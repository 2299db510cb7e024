"""Makes a new model version from corrections: refines an earlier one part by part, and compares the figures.

First a share of the corrected signs is held out; a trial version learns from the rest, and both versions are measured
on what was held out. Then the version that is kept learns from all corrections; its figures on corrections stay those
of the trial, as in the training on public data. Public scenes and crops, where folders are named, measure the version
that is kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.detection.acf import AcfModel
from tsr_engine.detection.prior import SpatialPrior
from tsr_engine.errors import InputError, ModelError, UsageError
from tsr_engine.io.models import SHIPPED, Component, load_component, read_manifest, save_component
from tsr_engine.io.pictures import read_picture
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.labels.classes import default_keys
from tsr_engine.pipeline import make_reader, one_blas_thread
from tsr_engine.plural import plural
from tsr_engine.recognition.classifier import NETWORK_COMPONENT, SignClassifier
from tsr_engine.training.corrections.class_mapping import drop_unseen_labels, map_to_classes, new_label_keys
from tsr_engine.training.corrections.corrected_scenes import CorrectedScene, Sampling, corrected_scenes, video_name
from tsr_engine.training.corrections.exports import OpenedExport
from tsr_engine.training.corrections.holdout import (
    HoldoutSplit,
    evaluate_detection,
    evaluate_reading,
    hold_out,
    regressions,
)
from tsr_engine.training.corrections.network_choice import compare_with_network, network_note
from tsr_engine.training.corrections.public_figures import public_figures, remembered_figures
from tsr_engine.training.corrections.refine_classifier import (
    ClassifierRefinement,
    SignCrop,
    refine_classifier,
    sign_crops,
    with_labels,
)
from tsr_engine.training.corrections.refine_detector import DetectorRefinement, refine_detector
from tsr_engine.training.corrections.refine_online import refine_online
from tsr_engine.training.corrections.refine_prior import blended_table, held_out_detections, refined_lambda
from tsr_engine.training.progress import Progress, named
from tsr_engine.training.public.memory import COMPONENT as MEMORY
from tsr_engine.training.public.memory import Samples
from tsr_engine.training.report import Report

__all__ = ["PARTS", "Recipe", "retrain"]

PARTS: Final = ("detector", "prior", "lambda", "classifier", "online")
Parts = dict[str, Component]

_SCENE_SIZE: Final = (1360, 800)
"""Size of GTSDB's pictures, px, for the detector's held-out detections."""


@dataclass(frozen=True, slots=True)
class Recipe:
    """Settings of a retraining; with data and parent they decide every byte.

    Attributes:
        parts: names among ``PARTS``.
        seed: seed of all randomness.
        held_out: share of the corrected videos or signs held out for figures; 0: none.
        sampling: which frames of a corrected video are used.
        detector: settings of the detector's refinement.
        classifier: settings of the classifier's refinement.
    """

    parts: tuple[str, ...] = PARTS
    seed: int = 0
    held_out: float = 0.25
    sampling: Sampling = field(default_factory=Sampling)
    detector: DetectorRefinement = field(default_factory=DetectorRefinement)
    classifier: ClassifierRefinement = field(default_factory=ClassifierRefinement)

    def __post_init__(self) -> None:
        unknown = [name for name in self.parts if name not in PARTS]
        if unknown or not self.parts:
            raise UsageError(f"Parts to train must be of {', '.join(PARTS)}. Got {', '.join(unknown) or 'none'}.")


def retrain(
    exports: Sequence[OpenedExport],
    recipe: Recipe,
    parent: Path | None,
    out: Path,
    work: Path,
    progress: Progress,
    *,
    gtsdb: Path | None = None,
    gtsrb: Path | None = None,
) -> Report:
    """Make a new version.

    Args:
        exports: the corrections.
        recipe: the settings.
        parent: folder of the earlier version; unset: the shipped one.
        out: folder for the new one; parts that are not trained are taken over from the parent.
        work: folder for temporary pictures.
        progress: called with stage, number done and total; may raise to stop.
        gtsdb: scenes for figures, of which training's report part is used.
        gtsrb: crops for figures, of which held-out tracks are used.

    Raises:
        InputError: there are no corrections to learn from, or a file cannot be read.
        ModelError: the parent is damaged or has no memory of its training.
        StorageError: no space.
    """
    with one_blas_thread():  # the order of sums, and so every byte, is independent of the number of cores
        old = _load(parent)
        keys = old["classifier"].params.get("labels") or default_keys()
        further = new_label_keys(exports, keys) if "classifier" in recipe.parts else ()
        exports = map_to_classes(exports, (*keys, *further))
        united = replace(exports[0].dataset, videos=[video for export in exports for video in export.dataset.videos])
        pictures = [own for export in exports for own in export.pictures]
        scenes = corrected_scenes(united, work, recipe.sampling, progress, pictures, recipe.seed)
        split_of_sign = {
            f"{video}/{uid}": subset for export in exports for (video, uid), subset in export.split.items()
        }
        _require_signs(scenes, exports)
        scenes, further = drop_unseen_labels(scenes, len(keys), further)
        base = {**old, "classifier": _extend_labels(old["classifier"], further)}
        holdout = hold_out(scenes, recipe.seed, recipe.held_out, split_of_sign, learned_videos(old))
        figures: JsonObject = {}
        worse: list[str] = []
        if holdout.held:
            trial, _ = _refine_parts(base, holdout.training, recipe, named("trial", progress))
            new_figures = _measure(trial, holdout.held, named("new version", progress))
            old_figures = _measure(old, holdout.held, named("earlier version", progress))
            figures["corrections"] = {
                "by": holdout.by,
                "signs": len(holdout.signs),
                "pictures": len(holdout.held),
                "new": new_figures,
                "parent": old_figures,
            }
            worse += regressions(new_figures, old_figures, "Held-out corrections")
        new, counts = _refine_parts(base, scenes, recipe, progress)
        for name, new_figures, old_figures in (
            ("remembered", remembered_figures(new), remembered_figures(old)),
            *public_figures(new, old, gtsdb, gtsrb, recipe.seed, progress),
        ):
            if new_figures:
                figures[name] = {"new": new_figures, "parent": old_figures}
                worse += regressions(new_figures, old_figures, _FIGURE_TITLES[name])
        figures["worse"] = worse
        lineage = _lineage(exports, recipe, parent, old, holdout, scenes, counts)
        if further:
            lineage |= {"labels": new["classifier"].params["labels"], "added_labels": list(further)}
        progress("writing", 0, 1)
        models = {}
        for name, component in new.items():
            own = component.figures or ({} if name == MEMORY else figures)  # an unchanged part keeps its own
            models[name] = save_component(replace(component, figures=own), out)
        return Report(figures, lineage, models)


_LEARNED: Final = "corrected_videos"
"""Name of the list of these videos in the facts about a component's data."""
_FIGURE_TITLES: Final = {"remembered": "Remembered training data", "gtsdb": "GTSDB scenes", "gtsrb": "GTSRB tracks"}


def _require_signs(scenes: Sequence[CorrectedScene], exports: Sequence[OpenedExport]) -> None:
    if any(scene.signs for scene in scenes):
        return
    notes = " ".join(note for export in exports for note in export.notes)
    raise InputError(
        "Expected corrected signs to learn from, found none: only tracks that people have accepted, corrected or drawn "
        f"teach, and their video or pictures must be there. {notes}".strip()
    )


def _load(parent: Path | None) -> Parts:
    folder = SHIPPED if parent is None else parent
    present = read_manifest(folder)["components"]
    for needed in ("detector", "classifier"):
        if needed not in present:
            raise ModelError(f"The models in {folder} have no component '{needed}', so they cannot be refined.")
    return {name: load_component(name, folder) for name in sorted(present)}


def learned_videos(parts: Parts) -> frozenset[str]:
    """Names of the videos whose corrections components, or those that they were refined from, have learned."""
    return frozenset(name for part in parts.values() for name in part.data.get(_LEARNED, ()))


def _memory(parts: Parts) -> tuple[tuple[Samples, Samples] | None, Component | None]:
    """Samples for training: two thirds of the remembered windows; the rest is for figures."""
    memory = parts.get(MEMORY)
    if memory is None:
        return None, None
    signs, others = (Samples.from_arrays(memory.arrays, name) for name in ("signs", "others"))
    return (signs.select(np.arange(len(signs)) % 3 > 0), others.select(np.arange(len(others)) % 3 > 0)), memory


def _refine_parts(
    old: Parts, scenes: Sequence[CorrectedScene], recipe: Recipe, progress: Progress
) -> tuple[Parts, JsonObject]:
    """All parts, refined or unchanged, and counts for the lineage."""
    new, counts = dict(old), {}
    remembered, memory = _memory(old)
    model = AcfModel.from_arrays(old["detector"].arrays, old["detector"].params)
    if "detector" in recipe.parts:
        refined, notes = refine_detector(model, scenes, remembered, recipe.detector, recipe.seed, progress)
        arrays, params = refined.to_arrays()
        kept = {k: v for k, v in old["detector"].arrays.items() if k.startswith("heldout_")}
        data = {**old["detector"].data, "refined": notes}
        new["detector"] = Component("detector", {**arrays, **kept}, params, data, {}, recipe.seed)
        counts["detector"] = notes
    if {"prior", "lambda"} & set(recipe.parts) and "prior" in old:
        new["prior"] = _refine_prior(old, model, scenes, recipe, progress)
        counts["prior"] = {"lambda": new["prior"].params["lambda"], "lambda_before": old["prior"].params["lambda"]}
    if "classifier" in recipe.parts:
        if memory is None:
            raise ModelError(
                "The earlier version has no memory of its training data, without which its classifier would forget "
                "other signs. Start from the shipped models, or leave the classifier out."
            )
        crops = sign_crops(scenes, progress)
        new["classifier"] = _refine_classifier_part(old["classifier"], crops, memory, recipe, progress)
        counts["classifier"] = {"crops": len(crops), "signs": len({item.sign for item in crops})}
        if NETWORK_COMPONENT in new:
            counts["network"] = compare_with_network(new, crops)
            if not counts["network"]["kept"]:
                del new[NETWORK_COMPONENT]
    if "online" in recipe.parts and "online" in old:
        progress("samples for the online detector", 0, 1)
        new["online"] = refine_online(old["online"], scenes, recipe.seed)
        counts["online"] = dict(new["online"].data)
    for name in [name for name in new if new[name] is not old[name]]:
        videos = {*learned_videos({name: old[name]}), *(scene.video for scene in scenes)}
        new[name] = replace(new[name], data={**new[name].data, _LEARNED: sorted(videos)})
    return new, counts


def _refine_prior(
    old: Parts, model: AcfModel, scenes: Sequence[CorrectedScene], recipe: Recipe, progress: Progress
) -> Component:
    """Refine table and lambda; lambda uses detections of the detector that has not seen the frames."""
    parent = old["prior"]
    table: NDArray[np.float32] = parent.arrays["table"].astype(np.float32)
    centres = int(parent.data.get("centres", old["detector"].data.get("scenes", {}).get("signs", 852)))
    if "prior" in recipe.parts:
        sizes = [(picture.shape[1], picture.shape[0]) for picture in (read_picture(s.scene.path) for s in scenes)]
        table, centres = blended_table(table, centres, scenes, sizes)
    weight = float(parent.params["lambda"])
    if "lambda" in recipe.parts:
        learned = learned_videos({"detector": old["detector"]})
        unseen = [scene for scene in scenes if scene.video not in learned]
        detected = held_out_detections(model, unseen, progress)
        found = refined_lambda(table, dict(old["detector"].arrays), _SCENE_SIZE, detected)
        weight = weight if found is None else round(found, 6)
    data = {**parent.data, "centres": centres}
    return Component("prior", {"table": table}, {**parent.params, "lambda": weight}, data, {}, recipe.seed)


def _extend_labels(old: Component, further: Sequence[str]) -> Component:
    """The classifier with room for further labels; its file is another one then."""
    if not further:
        return old
    extended = with_labels(SignClassifier.from_component(old), further)
    arrays = {**old.arrays, "weights": extended.weights.astype(np.float16), "bias": extended.bias}
    return Component("classifier", arrays, {**old.params, "labels": list(extended.labels)}, old.data, {}, old.seed)


def _refine_classifier_part(
    old: Component, crops: Sequence[SignCrop], memory: Component, recipe: Recipe, progress: Progress
) -> Component:
    classifier, moment = SignClassifier.from_component(old), memory.arrays["moment"].astype(np.float64)
    if len(moment) != classifier.features.length + 1:
        raise ModelError(
            "The memory of the earlier version is of a classifier with other features. Create it again with "
            "`tsr train memory`, or leave the classifier out."
        )
    tracks = int(memory.data.get("tracks", 1))
    weights, bias = refine_classifier(classifier, crops, moment, tracks, recipe.classifier, recipe.seed, progress)
    arrays = {**old.arrays, "weights": weights.astype(np.float16), "bias": bias}
    data = {**old.data, "refined": {"crops": len(crops), "signs": len({item.sign for item in crops})}}
    return Component("classifier", arrays, old.params, data, {}, recipe.seed)


def _measure(parts: Parts, held: Sequence[CorrectedScene], progress: Progress) -> JsonObject:
    """Figures of one version on held-out corrections."""
    model = AcfModel.from_arrays(parts["detector"].arrays, parts["detector"].params)
    prior = None
    if "prior" in parts:
        prior = SpatialPrior(parts["prior"].arrays["table"].astype(np.float32), float(parts["prior"].params["lambda"]))
    found = evaluate_detection(model, prior, held, progress)
    read = evaluate_reading(make_reader(parts), sign_crops(held, progress))
    return found | read


def _learned_note(holdout: HoldoutSplit, learned: frozenset[str]) -> list[str]:
    """The sentence for people about held-out videos that the earlier version has learned; none if there are none."""
    held = {scene.video for scene in holdout.held}
    if not held & learned:
        return []
    return [
        f"The figures on held-out corrections: the earlier version has learned from {len(held & learned)} of "
        f"{plural(len(held), 'video')} with held-out signs, so the figures of both versions are too high."
    ]


def _lineage(
    exports: Sequence[OpenedExport],
    recipe: Recipe,
    parent: Path | None,
    old: Parts,
    holdout: HoldoutSplit,
    scenes: Sequence[CorrectedScene],
    counts: JsonMapping,
) -> JsonObject:
    return {
        "parent": {"folder": None if parent is None else parent.name, "models": {n: c.sha256 for n, c in old.items()}},
        "parts": list(recipe.parts),
        "seed": recipe.seed,
        "exports": [dict(export.about) for export in exports],
        "notes": [
            *(note for export in exports for note in export.notes),
            *network_note(counts.get("network")),
            *_learned_note(holdout, learned_videos(old)),
        ],
        "held_out": {"share": recipe.held_out, "by": holdout.by, "signs": sorted(holdout.signs)},
        "used": {
            "frames": len(scenes),
            "videos": sorted({video_name(v) for export in exports for v in export.dataset.videos}),
            "signs": len({sign for scene in scenes for sign in scene.signs}),
            **counts,
        },
        **({} if (keys := old["classifier"].params.get("labels")) is None else {"labels": keys}),
        "settings": {"detector": asdict(recipe.detector), "classifier": asdict(recipe.classifier)},
    }
