"""Protocol B: labels of another country's signs, taught from all pictures but one and read in that one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from benchmarks.experiment import Data, Experiment, Result, Skip
from benchmarks.experiments.other_shapes import CLASSES, OTHERS, read_boxes
from benchmarks.reporting.markdown import table
from tsr_engine.io.models import load_component
from tsr_engine.io.pictures import read_picture
from tsr_engine.json_shapes import JsonMapping
from tsr_engine.labels.classes import default_keys
from tsr_engine.plural import plural
from tsr_engine.recognition.classifier import COMPONENT, SignClassifier
from tsr_engine.recognition.crops import cut
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.corrections.refine_classifier import (
    ClassifierRefinement,
    SignCrop,
    refine_classifier,
    with_labels,
)
from tsr_engine.training.public.memory import COMPONENT as MEMORY
from tsr_engine.training.synthetic.classifier_augmentation import LoadedCrop, surrounded_crop

FOLDER: Final = "dfg_half"
"""Of the folders of pictures of other countries, the one whose places have codes of a catalogue."""


@dataclass(frozen=True, slots=True)
class SignView:
    """A sign that one picture shows.

    Attributes:
        picture: its name.
        key: of the sign's label.
        crop: with surroundings, to learn from; its class is set when it is taught.
        view: as the classifier reads it.
    """

    picture: str
    key: str
    crop: LoadedCrop
    view: Picture


def leave_one_out(
    signs: Sequence[SignView], classifier: SignClassifier, moment: FloatArray, tracks: int
) -> dict[str, int]:
    """Leave out one picture after the other, teach the signs of all others, and read those of the one.

    Args:
        signs: of all pictures.
        classifier: the earlier one, of the 43 classes.
        moment: of the earlier data, see ``refine_classifier``.
        tracks: that the moment stands for.

    Returns:
        ``old`` and ``new``: signs of labels that the model has, and of those that it lacks and another picture shows;
        ``only_once``: those that it lacks and no other picture shows, which cannot be taught; ``old_before``,
        ``old_after`` and ``new_after``: those that are read right.
    """
    own = classifier.labels or default_keys()
    out = dict.fromkeys(("old", "old_before", "old_after", "new", "new_after", "only_once"), 0)
    for picture in dict.fromkeys(sign.picture for sign in signs):
        taught = [sign for sign in signs if sign.picture != picture]
        further = tuple(dict.fromkeys(sign.key for sign in taught if sign.key not in own))
        grown = with_labels(classifier, further)
        keys = [*own, *further]
        crops = [
            SignCrop(LoadedCrop(sign.crop.pixels, sign.crop.box, keys.index(sign.key)), str(number))
            for number, sign in enumerate(taught)
        ]
        weights, bias = refine_classifier(
            grown, crops, moment, tracks, ClassifierRefinement(), 0, lambda stage, done, total: None
        )
        for sign in (sign for sign in signs if sign.picture == picture):
            features = classifier.read([sign.view])
            read = keys[int((features @ weights + bias).argmax())]
            if sign.key in own:
                out["old"] += 1
                out["old_before"] += own[int(classifier.margins_of(features).argmax())] == sign.key
                out["old_after"] += read == sign.key
            elif sign.key in further:
                out["new"] += 1
                out["new_after"] += read == sign.key
            else:
                out["only_once"] += 1
    return out


def _run(data: Data) -> Result:
    folder = data.need("foreign") / FOLDER
    if not folder.is_dir():
        raise Skip(f"no data: the folder `foreign` has no {FOLDER}.")
    classifier, memory = SignClassifier.from_component(load_component(COMPONENT)), load_component(MEMORY)
    names = CLASSES | OTHERS
    signs: list[SignView] = []
    for name, places in read_boxes(folder).items():
        picture = read_picture(folder / name)
        for place in places:
            if place.kind:
                view = cut(picture, place.box, classifier.margin)
                signs.append(SignView(name, names[place.name], surrounded_crop(picture, place.box, 0), view))
    moment = memory.arrays["moment"].astype(np.float64)
    return Result(
        data=f"{len(signs)} upright signs of the label set `vienna` in {len({s.picture for s in signs})} Slovenian "
        "road scenes, cropped at their annotated boxes. Nothing was chosen on them.",
        figures=leave_one_out(signs, classifier, moment, int(memory.data.get("tracks", 1))),
        settings={"classifier": load_component("classifier").sha256[:12]},
    )


def _report(result: Result) -> str:
    return f"{_text(result.figures)}\n"


def _text(f: JsonMapping | Mapping[str, int]) -> str:
    rows = [
        ["signs", "number", "read right before", "after teaching"],
        ["of new labels, seen in another scene", str(f["new"]), "0", str(f["new_after"])],
        ["of the 43 labels", str(f["old"]), str(f["old_before"]), str(f["old_after"])],
    ]
    return (
        f"{table(rows)}\nEach scene is left out once; the signs of all others are taught as in a retraining, one frame "
        f"each. Labels that no other scene shows cannot be taught: {plural(f['only_once'], 'sign')}."
    )


EXPERIMENT = Experiment(
    "teaching_abroad",
    "Teaching another country's signs",
    "How much do a few annotated scenes of another country teach a model of 43 German signs?",
    _run,
    _report,
)
