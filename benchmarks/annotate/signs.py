"""Makes the annotations from the annotator's answers."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from benchmarks.annotate.answers import AnnotatedPlace, Control
from benchmarks.annotate.fitting import fit_box
from benchmarks.experiment import ROOT
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.pictures import read_picture
from tsr_engine.labels.files import VIENNA, shipped_set
from tsr_engine.labels.model import Label
from tsr_engine.training.public.gtsdb_signs import Annotation, Annotations, Reason

SIGNS: Final = ROOT / "data" / "gtsdb_signs.json"
LONGER, SHORTER = 14.0, 8.0
"""Least sides of a box, px; smaller signs are ignored."""
_ROUND: Final = ("circle", "diamond", "octagon")
_DISCS: Final = ("bus-stop",)
"""Rectangles in the label set, discs in Germany."""
ABOUT: Final = (
    "Upright signs of the 600 training scenes of GTSDB that gt.txt does not name: found on cut-outs of candidates and "
    "on whole scenes, named at a close look and once more in shuffled order. Made by "
    "`python -m benchmarks.annotate compile` from gtsdb_signs_seen.csv; see docs/annotations-gtsdb.md."
)


def compile_signs(seen: Sequence[AnnotatedPlace], controls: Sequence[Control], scenes: Sequence[Scene]) -> Annotations:
    """Annotations with fitted boxes.

    Raises:
        KeyError: the scene of a place is missing.
        ValueError: an answer is neither one of ``WORDS`` nor a label of the set.
    """
    labels = {label.key: label for label in shipped_set(VIENNA)}
    by_name = {scene.path.stem: scene for scene in scenes}
    found: list[Annotation] = []
    picture, name = None, ""
    for place in sorted(seen, key=lambda place: (place.scene, place.box[1], place.box[0])):
        if place.answer == "none":
            continue
        label = labels.get(place.answer)
        box = np.array(place.box)
        if label is not None or place.answer == "other":
            if picture is None or name != place.scene:
                picture, name = read_picture(by_name[place.scene].path), place.scene
            disc = label is not None and (label.shape in _ROUND or label.key in _DISCS)
            box = fit_box(picture, box, round_sign=disc)
        found.append(_annotation(len(found) + 1, place, label, tuple(round(float(v), 1) for v in box)))
    return Annotations(about=ABOUT, label_set=VIENNA, figures=figures(seen, controls), signs=tuple(found))


_REASONS: Final[Mapping[str, Reason]] = {
    "other": "not in the label set",
    "unread": "unread",
    "vehicle": "on a vehicle",
    "board": "board",
}


def _annotation(number: int, place: AnnotatedPlace, label: Label | None, box: tuple[float, ...]) -> Annotation:
    x1, y1, x2, y2 = box
    reason: Reason = ""
    if label is None:
        if place.answer not in _REASONS:
            raise ValueError(f"Scene {place.scene}: {place.answer!r} is no label of {VIENNA} and no other answer.")
        reason = _REASONS[place.answer]
    elif max(x2 - x1, y2 - y1) < LONGER or min(x2 - x1, y2 - y1) < SHORTER:
        reason = "small"
    plate = place.answer == "other" if label is None else label.category == "additional"
    return Annotation(
        id=number,
        scene=place.scene,
        box=(x1, y1, x2, y2),
        label=None if label is None else label.key,
        kind="board" if place.answer == "board" else "plate" if plate else "sign",
        ignore=bool(reason),
        reason=reason,
    )


def figures(seen: Sequence[AnnotatedPlace], controls: Sequence[Control]) -> dict[str, int | float]:
    """Agreement of the looks.

    Returns:
        Numbers of labelled signs that each search found, and both; the estimated total (Lincoln and Petersen); numbers
        of signs that were named twice, and with the same name; numbers of controls, and of those named as in
        ``gt.txt``.
    """
    words = ("none", "other", "unread", "vehicle", "board")
    panels = {label.key for label in shipped_set(VIENNA) if label.category == "additional"}
    named = [place for place in seen if place.answer not in (*words, *panels)]
    found = Counter((bool(place.cutouts), bool(place.scenes)) for place in named)
    by_cutouts = found[True, True] + found[True, False]
    by_scenes = found[True, True] + found[False, True]
    twice = [place for place in seen if place.again]
    return {
        "signs_named": len(named),
        "found_on_cutouts": by_cutouts,
        "found_on_scenes": by_scenes,
        "found_on_both": found[True, True],
        "signs_expected": round(by_cutouts * by_scenes / max(found[True, True], 1), 1),
        "named_twice": len(twice),
        "named_alike": sum(place.alike for place in twice),
        "settled": sum(bool(place.settled) for place in seen),
        "controls": len(controls),
        "controls_right": sum(control.truth == control.again for control in controls),
        "controls_unread": sum(control.again == "unread" for control in controls),
    }


def save(annotations: Annotations, path: Path = SIGNS) -> None:
    """Write one sign per line, so that diffs are readable."""
    head = json.dumps(annotations.model_dump(mode="json", exclude={"signs"}), indent=1)
    lines = ",\n  ".join(sign.model_dump_json() for sign in annotations.signs)
    head = head.removesuffix("\n}")
    path.write_text(f'{head},\n "signs": [\n  {lines}\n ]\n}}\n', encoding="utf-8")
