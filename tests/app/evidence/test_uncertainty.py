"""Uncertainty: each reason alone, all together, and the effect of other runs and of people."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.evidence.disagreement import compare_with_run, overruled
from app.evidence.run_columns import confirmed_boxes
from app.evidence.tracks import read_track_properties
from app.evidence.uncertainty import IMPORTED, WEIGHTS, Disagreement, UncertaintyInput, terms, uncertainties
from app.storage.models import Run, TrackDocument
from tests.app import toy_home
from tsr_engine.labels.files import shipped_set

GTSRB = shipped_set("gtsrb-43")


def certain_track(**changes: Any) -> UncertaintyInput:
    """A track without any reason for uncertainty."""
    given: dict[str, Any] = {
        "frames": [30],
        "detected": [30],
        "name": ["stop"],
        "share": [1.0],
        "runner_up": ["give way"],
        "runner_up_share": [0.0],
        "rejected": [0],
        "judged": [29],
        "windows": False,
        "by_engine": True,
    }
    given |= changes
    floats = {"share", "runner_up_share"}
    plain = {"name", "runner_up", "windows", "by_engine"}
    arrays = {k: v if k in plain else np.array(v, float if k in floats else int) for k, v in given.items()}
    return UncertaintyInput(**arrays)


def test_a_clear_track_has_low_uncertainty() -> None:
    found = uncertainties(certain_track(), None)
    assert 0 < found.uncertainty[0] < 0.02
    assert found.reasons == [[]]


@pytest.mark.parametrize(
    ("changes", "term", "value", "sentence"),
    [
        ({"share": [0.5], "runner_up_share": [0.2]}, "margin", 0.7, "'stop' has 50 % of the votes, 'give way' 20 %."),
        (
            {"share": [0.6], "runner_up": [None], "runner_up_share": [np.nan]},
            "margin",
            0.4,
            "'stop' has 60 % of the votes.",
        ),
        ({"name": [None], "share": [np.nan], "runner_up_share": [np.nan]}, "margin", 1.0, "It was never recognised."),
        ({"frames": [9], "detected": [9]}, "short", 0.5, "It is short: 9 frames."),
        ({"frames": [1], "detected": [1], "judged": [0]}, "short", 1.0, "It is short: 1 frame."),
        ({"detected": [12]}, "gaps", 0.6, "No detection in 18 of 30 frames."),
        ({"rejected": [12], "judged": [30]}, "rejected", 0.4, "The gate rejected its prediction in 12 of 30 frames."),
    ],
)
def test_each_reason_alone(changes: dict[str, Any], term: str, value: float, sentence: str) -> None:
    given = certain_track(**changes)
    assert {name: one[0] for name, one in terms(given).items() if one[0]} == {term: pytest.approx(value)}
    found = uncertainties(given, None)
    chance = 1 / (1 + math.exp(-WEIGHTS["constant"] - WEIGHTS[term] * value))
    assert found.uncertainty[0] == pytest.approx(chance, abs=1e-4)
    assert found.rank.tolist() == found.uncertainty.tolist()
    assert found.reasons == [[sentence]]


def test_a_run_that_measures_windows_is_less_certain_without_a_reason_against_a_track() -> None:
    """Windows have a fixed size, so people correct most tracks of the preset ``paper``."""
    found = uncertainties(certain_track(windows=True), None)
    assert 0.1 < found.uncertainty[0] < 0.3
    assert found.reasons == [[]]


def test_the_largest_reason_comes_first_and_another_run_last() -> None:
    given = certain_track(frames=[9], detected=[9], share=[0.5], runner_up_share=[0.2])
    other = Disagreement(np.array([1.0]), ["Run 2 labels it 'yield'."])
    found = uncertainties(given, other)
    assert [reason.split()[0] for reason in found.reasons[0]] == ["'stop'", "It", "Run"]
    assert found.uncertainty.tolist() == uncertainties(given, None).uncertainty.tolist()


def test_many_small_reasons_are_named_by_the_largest() -> None:
    given = certain_track(frames=[13], detected=[12], share=[0.88], runner_up_share=[0.02], judged=[13], rejected=[1])
    added = {name: WEIGHTS[name] * one[0] for name, one in terms(given).items()}
    assert max(added.values()) < 0.5 < sum(added.values())
    assert max(added, key=lambda name: added[name]) == "margin"
    assert uncertainties(given, None).reasons == [["'stop' has 88 % of the votes, 'give way' 2 %."]]


def test_an_imported_run_is_ordered_by_other_runs_without_a_percentage() -> None:
    given = certain_track(frames=[30, 30], detected=[30, 30], name=["stop"] * 2, runner_up=[None] * 2, by_engine=False)
    other = Disagreement(np.array([0.0, 1.0]), ["", "Run 2 labels it 'yield'."])
    found = uncertainties(given, other)
    assert np.isnan(found.uncertainty).all()
    assert found.rank.tolist() == [0.0, 1.0]
    assert found.reasons == [[IMPORTED], ["Run 2 labels it 'yield'.", IMPORTED]]
    assert uncertainties(given, None).rank.tolist() == [0.0, 0.0]


def test_uncertainty_never_falls_when_a_track_gets_worse() -> None:
    rng = np.random.default_rng(3)
    n = 200
    frames = rng.integers(2, 60, n)
    given = UncertaintyInput(
        frames=frames,
        detected=frames,
        name=["stop"] * n,
        share=rng.uniform(0.3, 1, n),
        runner_up=["give way"] * n,
        runner_up_share=rng.uniform(0, 0.3, n),
        rejected=rng.integers(0, 10, n),
        judged=np.full(n, 10),
        windows=False,
        by_engine=True,
    )
    before = uncertainties(given, None).uncertainty
    assert ((before > 0) & (before < 1)).all()
    for worse in (
        replace(given, runner_up_share=given.runner_up_share + 0.1),
        replace(given, frames=np.maximum(frames - 3, 1), detected=np.maximum(frames - 3, 1)),
        replace(given, detected=frames // 2),
        replace(given, rejected=given.rejected + 1),
        replace(given, windows=True),
    ):
        assert (uncertainties(worse, None).uncertainty >= before).all()


def test_a_contradicting_run_raises_the_uncertainty(home: Any) -> None:
    with home.reader() as reader:
        run_boxes, facts = confirmed_boxes(reader), read_track_properties(reader)
    agrees = compare_with_run(run_boxes, run_boxes, facts, "Run 2", (0, 75), GTSRB)
    assert agrees.weight.tolist() == [0.0] * len(facts.id)
    relabelled = replace(run_boxes, class_id=np.where(run_boxes.track == 0, 30, run_boxes.class_id))
    other = compare_with_run(run_boxes, relabelled, facts, "Run 2", (0, 75), GTSRB)
    assert other.weight[0] == 1.0
    assert other.sentence[0] == "Run 2 labels it 'ice or snow'."
    assert other.weight[1:].tolist() == [0.0] * (len(facts.id) - 1)
    without = run_boxes.rows(run_boxes.track == 0)
    lost = compare_with_run(run_boxes, without, facts, "Run 2", (0, 75), GTSRB)
    assert lost.weight.tolist() == [0.0] + [0.5] * (len(facts.id) - 1)
    assert lost.sentence[1] == "Run 2 has no such track."
    # Frames that the other run did not process do not count.
    unseen = compare_with_run(run_boxes, without, facts, "Run 2", (0, int(facts.last[1])), GTSRB)
    assert unseen.weight.tolist() == [0.0] * len(facts.id)


def test_a_contradicting_person_raises_the_uncertainty(home: Any) -> None:
    with home.reader() as reader:
        facts = read_track_properties(reader)
    first, second = (f"m{track}" for track in facts.id[:2].tolist())
    rest = [False] * (len(facts.id) - 2)
    own = int(facts.class_id[0])
    other = (own + 1) % 43
    for document, expected in (
        ({"class_id": other}, True),
        ({"class_id": own}, False),
        ({"class_id": None}, False),
        ({"class_id": -1}, True),
        ({"class_id": None, "not_a_sign": True}, True),
        ({"class_id": other, "review": "needs_work"}, True),
        ({"class_id": other, "review": "accepted"}, False),
        ({"not_a_sign": True, "review": "rejected"}, False),
    ):
        found = overruled({first: document, "h123456": {"class_id": 3}, second: {}}, facts, GTSRB)
        assert found.tolist() == [expected, False, *rest], document


def test_the_queue_follows_edits_and_new_runs(tmp_path: Any) -> None:
    import shutil

    home = toy_home.make_home(tmp_path)
    try:
        before = json.loads(home.evidence.tracks(home.run_id))
        key = f"m{before['id'][0]}"
        with home.database.write() as session:
            session.add(TrackDocument(run_id=home.run_id, key=key, revision=1, document={"class_id": 2}))
            session.add(_edit(home.run_id))
        after = json.loads(home.evidence.tracks(home.run_id))
        assert after["rank"] == [1.0, *before["rank"][1:]]
        assert {**after, "rank": before["rank"]} == before
        other = home.add_run(name="Run 2")
        shutil.copytree(home.folder, home.settings.home / "runs" / other)
        assert json.loads(home.evidence.tracks(home.run_id))["uncertainty"] == after["uncertainty"]
        with home.database.write() as session:
            session.delete(session.get(Run, other))
        home.evidence.forget(other)
        assert json.loads(home.evidence.tracks(home.run_id)) == after
    finally:
        home.evidence.close()
        home.database.close()


def _edit(run_id: str) -> Any:
    from app.storage.models import Edit

    return Edit(op_id="op", run_id=run_id, author="a", kind="relabel_track", command={}, frame=0, before={}, after={})
