"""The annotations of GTSDB's other signs, and how they are made."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.annotate.answers import WORDS, AnnotatedPlace, Control, read_controls, read_places
from benchmarks.annotate.candidates import blobs
from benchmarks.annotate.fitting import fit_box
from benchmarks.annotate.signs import LONGER, SHORTER, SIGNS, compile_signs, figures, save
from tsr_engine.geometry.boxes import iou
from tsr_engine.io.gtsdb import Scene, read_gtsdb
from tsr_engine.labels.files import shipped_set
from tsr_engine.training.public.gtsdb_signs import Annotations, read_signs

WIDTH, HEIGHT, SCENES = 1360, 800, 600


@pytest.fixture(scope="module")
def annotations() -> Annotations:
    return read_signs(SIGNS)


def test_committed_signs_lie_in_their_picture_and_have_known_labels(annotations: Annotations):
    keys = {label.key for label in shipped_set(annotations.label_set)}
    assert [sign.id for sign in annotations.signs] == list(range(1, len(annotations.signs) + 1))
    for sign in annotations.signs:
        x1, y1, x2, y2 = sign.box
        assert 0 <= x1 < x2 <= WIDTH, sign
        assert 0 <= y1 < y2 <= HEIGHT, sign
        assert int(sign.scene) < SCENES, sign
        assert sign.label is None or sign.label in keys, sign
        assert sign.ignore == bool(sign.reason), sign
        assert sign.label is not None or sign.ignore, sign
        if not sign.ignore:
            assert max(x2 - x1, y2 - y1) >= LONGER, sign
            assert min(x2 - x1, y2 - y1) >= SHORTER, sign


def test_no_committed_sign_is_doubled(annotations: Annotations):
    for scene in {sign.scene for sign in annotations.signs}:
        boxes = np.array([sign.box for sign in annotations.signs if sign.scene == scene])
        overlaps = iou(boxes, boxes)[np.triu_indices(len(boxes), 1)]
        assert overlaps.max(initial=0) < 0.5, scene


def test_answers_are_labels_or_known_words():
    known = {label.key for label in shipped_set("vienna")} | set(WORDS)
    for place in read_places():
        assert {place.cutouts, place.scenes, place.close, place.again, place.settled} <= known, place


def test_every_disagreement_about_a_label_is_settled_or_ignored(annotations: Annotations):
    for place in read_places():
        if not place.alike and not place.settled:
            assert place.answer == "unread"
    assert annotations.figures == figures(read_places(), read_controls())


@pytest.mark.data
def test_the_committed_annotations_follow_from_the_answers(gtsdb: Path, annotations: Annotations):
    scenes = read_gtsdb(gtsdb)
    assert compile_signs(read_places(), read_controls(), scenes) == annotations
    known = {scene.path.stem: scene.boxes for scene in scenes}
    for sign in annotations.signs:  # a zone sign contains a speed limit that gt.txt lists
        overlap = iou(np.array(sign.box), known[sign.scene]).max(initial=0)
        assert overlap < 0.3 or (overlap < 0.7 and (sign.label or "").startswith("speed-limit-zone")), sign


def test_two_answers_that_disagree_give_no_label():
    seen = [
        _seen("parking", again="parking"),
        _seen("parking", again="bus-stop"),
        _seen("parking", again="bus-stop", settled="bus-stop"),
        _seen("vehicle", again="unread"),
    ]
    assert [place.answer for place in seen] == ["parking", "unread", "bus-stop", "vehicle"]


def test_figures_count_what_each_search_found():
    seen = [
        _seen("parking", cutouts="unsure", scenes="parking", again="parking"),
        _seen("parking", scenes="parking", again="no-parking", settled="parking"),
        _seen("motorway", cutouts="motorway", scenes="motorway"),
        _seen("time-panel", scenes="time-panel"),
        _seen("none", cutouts="unsure"),
    ]
    found = figures(seen, [Control("stop", "stop"), Control("stop", "unread")])
    assert (found["signs_named"], found["found_on_cutouts"], found["found_on_scenes"]) == (3, 2, 3)
    assert (found["found_on_both"], found["signs_expected"]) == (2, 3.0)
    assert (found["named_twice"], found["named_alike"], found["settled"]) == (2, 1, 1)
    assert (found["controls"], found["controls_right"], found["controls_unread"]) == (2, 1, 1)


def test_annotations_are_compiled_from_answers(tmp_path: Path):
    picture = np.full((HEIGHT, WIDTH, 3), 90, np.uint8)
    cv2.rectangle(picture, (300, 200), (339, 239), (200, 60, 20), cv2.FILLED)
    cv2.imwrite(str(tmp_path / "00007.png"), picture)
    scene = Scene("00007.png", tmp_path / "00007.png", np.zeros((0, 4)), np.zeros(0, np.int64))
    seen = [
        _seen("parking", box=(298, 203, 342, 238)),
        _seen("other", box=(600, 300, 640, 320)),
        _seen("bus-stop", box=(700, 300, 711, 311)),
        _seen("board", box=(10, 400, 90, 480)),
        _seen("none", box=(10, 500, 90, 580)),
    ]
    compiled = compile_signs(seen, [], [scene])
    assert [(s.label, s.kind, s.ignore, s.reason) for s in compiled.signs] == [
        ("parking", "sign", False, ""),
        (None, "plate", True, "not in the label set"),
        ("bus-stop", "sign", True, "small"),
        (None, "board", True, "board"),
    ]
    assert compiled.signs[0].box == pytest.approx((300, 200, 340, 240), abs=1)
    save(compiled, tmp_path / "signs.json")
    text = (tmp_path / "signs.json").read_text(encoding="utf-8")
    assert Annotations.model_validate_json(text) == compiled
    assert len(json.loads(text)["signs"]) == 4


def test_an_unknown_label_is_refused(tmp_path: Path):
    with pytest.raises(ValueError, match="Scene 00007: 'parkin' is no label of vienna"):
        compile_signs([_seen("parkin")], [], [])


@pytest.mark.parametrize("round_sign", [False, True])
def test_a_rough_box_is_moved_to_the_edges(round_sign: bool):
    rng = np.random.default_rng(5)
    overlaps = []
    for _ in range(20):
        picture = rng.integers(60, 110, (160, 200, 3)).astype(np.uint8)
        side = int(rng.integers(18, 60))
        left, top = 70, 50
        if round_sign:
            cv2.circle(picture, (left + side // 2, top + side // 2), side // 2, (30, 30, 220), cv2.FILLED)
            side += 1 - side % 2
        else:
            cv2.rectangle(picture, (left, top), (left + side - 1, top + side - 1), (230, 230, 230), cv2.FILLED)
        truth = np.array([left, top, left + side, top + side], dtype=np.float64)
        rough = truth + rng.uniform(-0.07, 0.07, 4) * side
        overlaps.append(float(iou(fit_box(picture, rough, round_sign=round_sign), truth).item()))
    assert np.median(overlaps) > (0.91 if round_sign else 0.95)
    assert min(overlaps) > 0.85  # the rough boxes: 0.85 on average


def test_blobs_have_the_colour_and_the_form_of_signs():
    picture = np.full((HEIGHT, WIDTH, 3), 120, np.uint8)
    cv2.rectangle(picture, (200, 300), (239, 339), (190, 70, 20), cv2.FILLED)
    cv2.rectangle(picture, (400, 300), (640, 320), (190, 70, 20), cv2.FILLED)  # a bar
    cv2.rectangle(picture, (800, 300), (839, 339), (90, 160, 90), cv2.FILLED)  # grey-green
    cv2.rectangle(picture, (200, 20), (239, 59), (190, 70, 20), cv2.FILLED)  # too high up
    assert blobs(picture).tolist() == [[200, 300, 240, 340]]


def test_annotations_cover_common_signs(annotations: Annotations):
    labels = Counter(sign.label for sign in annotations.signs if sign.label and not sign.ignore)
    assert {"parking", "pedestrian-crossing", "bus-stop", "motorway", "one-way-to-the-right"} <= set(labels)
    assert annotations.figures["controls_right"] >= 0.9 * annotations.figures["controls"]


def _seen(
    close: str,
    *,
    box: tuple[float, float, float, float] = (10, 10, 30, 30),
    cutouts: str = "",
    scenes: str = "",
    again: str = "",
    settled: str = "",
) -> AnnotatedPlace:
    return AnnotatedPlace("00007", box, cutouts, scenes, close, again, settled)
