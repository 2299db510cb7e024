"""Uncertainty: each reason by itself, together, and what other runs and people say."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.evidence.disagreement import against_run, overruled
from app.evidence.tables import confirmed_boxes
from app.evidence.tracks import track_facts
from app.evidence.uncertainty import CLEAR_RATIO, Disagreement, UncertaintyInput, uncertainties
from app.storage.models import Run, TrackDocument
from tsr_engine.labels.files import shipped_set

GTSRB = shipped_set("gtsrb-43")


def sure(**changes: Any) -> UncertaintyInput:
    """One track that nothing speaks against."""
    given: dict[str, Any] = {
        "frames": [30],
        "predicted": [0],
        "name": ["stop"],
        "share": [0.95],
        "runner_up": ["give way"],
        "runner_up_share": [0.05],
        "closest": [np.inf],
        "closest_frame": [-1],
        "closest_value": [np.nan],
        "near": [0],
        "judged": [29],
        "tau": 15.0,
    }
    given |= changes
    floats = {"share", "runner_up_share", "closest", "closest_value"}
    plain = {"name", "runner_up", "tau"}
    arrays = {k: v if k in plain else np.array(v, float if k in floats else int) for k, v in given.items()}
    return UncertaintyInput(**arrays)


def test_a_clear_track_is_not_uncertain() -> None:
    found = uncertainties(sure(), [])
    assert found.uncertainty.tolist() == [0.0]
    assert found.reasons == [[]]


@pytest.mark.parametrize(
    ("changes", "uncertainty", "sentence"),
    [
        ({"share": [0.5], "runner_up_share": [0.2]}, 0.5, "'stop' has 50% of the votes, 'give way' 20%."),
        ({"share": [0.4], "runner_up_share": [0.4]}, 1.0, "'stop' has 40% of the votes, 'give way' 40%."),
        ({"name": [None], "share": [np.nan]}, 1.0, "It was never recognised."),
        ({"frames": [9]}, 0.35, "It is short: 9 frames."),
        ({"frames": [1], "judged": [0]}, 0.7, "It is short: 1 frame."),
        ({"predicted": [9]}, 0.3, "9 of its 30 frames are predictions without a measurement."),
        (
            {"closest": [np.log(CLEAR_RATIO) / 2], "closest_frame": [7], "closest_value": [26.0], "near": [29]},
            0.25,
            "29 of 29 verdicts of the gate were close, the closest in frame 7: L = 26.0 beside tau = 15.",
        ),
        (
            {"closest": [0.0], "closest_frame": [7], "closest_value": [15.0], "near": [4], "judged": [32]},
            0.25,
            "4 of 32 verdicts of the gate were close, the closest in frame 7: L = 15.0 beside tau = 15.",
        ),
    ],
)
def test_each_reason_alone(changes: dict[str, Any], uncertainty: float, sentence: str) -> None:
    found = uncertainties(sure(**changes), [])
    assert found.uncertainty[0] == pytest.approx(uncertainty, abs=1e-3)
    assert found.reasons == [[sentence]]


def test_reasons_add_up_and_the_weightiest_comes_first() -> None:
    found = uncertainties(sure(frames=[9], share=[0.5], runner_up_share=[0.2]), [])
    assert found.uncertainty[0] == pytest.approx(1 - (1 - 0.5) * (1 - 0.35), abs=1e-3)
    assert [reason.split()[0] for reason in found.reasons[0]] == ["'stop'", "It"]
    other = Disagreement(np.array([1.0]), ["Run 2 calls it 'yield'."])
    contradicted = uncertainties(sure(frames=[9]), [other])
    assert contradicted.uncertainty[0] == 1.0
    assert contradicted.reasons[0][0] == "Run 2 calls it 'yield'."


def test_uncertainty_never_falls_when_a_track_gets_worse() -> None:
    rng = np.random.default_rng(3)
    n = 200
    given = UncertaintyInput(
        frames=rng.integers(1, 60, n),
        predicted=np.zeros(n, int),
        name=["stop"] * n,
        share=rng.uniform(0.3, 1, n),
        runner_up=["give way"] * n,
        runner_up_share=rng.uniform(0, 0.3, n),
        closest=rng.exponential(1, n),
        closest_frame=np.zeros(n, int),
        closest_value=np.full(n, 10.0),
        near=rng.integers(0, 10, n),
        judged=np.full(n, 10),
        tau=15.0,
    )
    before = uncertainties(given, []).uncertainty
    assert ((before >= 0) & (before <= 1)).all()
    for worse in (
        replace(given, runner_up_share=given.runner_up_share + 0.1),
        replace(given, frames=np.maximum(given.frames - 3, 1)),
        replace(given, predicted=given.frames // 2),
        replace(given, closest=given.closest / 2),
        replace(given, near=given.near + 1),
    ):
        assert (uncertainties(worse, []).uncertainty >= before).all()


def test_another_run_that_says_something_else(home: Any) -> None:
    with home.reader() as reader:
        mine, facts = confirmed_boxes(reader), track_facts(reader)
    agrees = against_run(mine, mine, facts, "Run 2", (0, 75), GTSRB)
    assert agrees.weight.tolist() == [0.0] * len(facts.id)
    relabelled = replace(mine, class_id=np.where(mine.track == 0, 30, mine.class_id))
    other = against_run(mine, relabelled, facts, "Run 2", (0, 75), GTSRB)
    assert other.weight[0] == 1.0
    assert other.sentence[0] == "Run 2 calls it 'ice or snow'."
    assert other.weight[1:].tolist() == [0.0] * (len(facts.id) - 1)
    first = mine.track == 0
    without = replace(
        mine,
        frame=mine.frame[first],
        track=mine.track[first],
        boxes=mine.boxes[first],
        class_id=mine.class_id[first],
        ignore=mine.ignore[first],
        source=mine.source[first],
    )
    lost = against_run(mine, without, facts, "Run 2", (0, 75), GTSRB)
    assert lost.weight.tolist() == [0.0] + [0.5] * (len(facts.id) - 1)
    assert lost.sentence[1] == "Run 2 has no such track."
    # What the other run never looked at says nothing.
    unseen = against_run(mine, without, facts, "Run 2", (0, int(facts.last[1])), GTSRB)
    assert unseen.weight.tolist() == [0.0] * len(facts.id)


def test_a_person_who_says_something_else(home: Any) -> None:
    with home.reader() as reader:
        facts = track_facts(reader)
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


def test_the_queue_hears_of_edits_and_of_new_runs(toy_homes: Any, tmp_path: Any) -> None:
    import shutil

    home = toy_homes.make_home(tmp_path)
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
