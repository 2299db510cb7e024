"""Figures of a check against values computed by hand, with intervals and budgets."""

from __future__ import annotations

import pytest

from app.check.figures import FIGURES, budgets, changes, over_budget
from tsr_engine.errors import UsageError
from tsr_engine.evaluation.tracking import SignReport, VideoReport


def sign_report(number: int, covered: int, read: int | None = 3, class_id: int = 3) -> SignReport:
    return SignReport(number, class_id, 10, covered, (1,) if covered else (), 0, 0, read if covered else None)


def video_report(*signs: SignReport, false: int = 0, error: float = 0.1) -> VideoReport:
    matched = tuple((frame, sign.track_id) for sign in signs for frame in range(sign.covered))
    errors = tuple((error, "detected") for _ in matched)
    return VideoReport("d", 500, signs, errors, (), 5, tuple(range(false)), 0, matched)


def test_figures_follow_their_definition() -> None:
    before = [video_report(sign_report(1, 10), sign_report(2, 5, 4)), video_report(sign_report(1, 10), false=1)]
    after = [video_report(sign_report(1, 10), sign_report(2, 0)), video_report(sign_report(1, 5), false=3, error=0.2)]
    found, unit = changes(before, after)
    assert unit == "signs"
    values = {change.name: (change.before, change.after) for change in found}
    assert list(values) == list(FIGURES)
    assert values["found"] == pytest.approx((100.0, 200 / 3))
    assert values["coverage"] == pytest.approx((100 * 25 / 30, 50.0))
    assert values["read"] == pytest.approx((200 / 3, 200 / 3))
    assert values["false"] == pytest.approx((1.0, 3.0))
    assert values["error"] == pytest.approx((0.1, (10 * 0.1 + 5 * 0.2) / 15))
    for change in found:
        assert change.difference == pytest.approx(change.after - change.before)  # type: ignore[operator]


def test_signs_without_a_class_are_not_classified() -> None:
    report = video_report(sign_report(1, 10, -1, class_id=-1))
    found = {change.name: change for change in changes([report], [report])[0]}
    assert found["read"].before is found["read"].after is found["read"].difference is None
    assert found["found"].before == 100


def test_an_interval_holds_the_difference_and_drives_are_drawn_from_eight_on() -> None:
    before = [video_report(sign_report(1, 10), sign_report(2, 10)) for _ in range(12)]
    after = [video_report(sign_report(1, 10), sign_report(2, k % 4)) for k in range(12)]
    found, unit = changes(before, after)
    assert unit == "drives"
    coverage = found[1]
    assert coverage.interval is not None
    assert coverage.interval[0] < coverage.difference < coverage.interval[1] < 0  # type: ignore[operator]
    assert changes(before, after) == (found, unit), "the same call gives the same interval"
    same = changes(before, before)[0]
    assert all(change.interval in ((0.0, 0.0), None) for change in same)


def test_exceeded_budgets_are_named() -> None:
    before, after = (
        [video_report(sign_report(1, 10), sign_report(2, 10))],
        [video_report(sign_report(1, 10), sign_report(2, 9), false=1)],
    )
    found, _ = changes(before, after)
    assert over_budget(found, budgets(["coverage=-5", "read=0", "false=2"])) == []
    reported = over_budget(found, budgets(["coverage=-4.9", "false=1", "found=0"]))
    assert reported == [
        "coverage went from 100 to 95, by -5; its budget is -4.9.",
        "false went from 0 to 2, by +2; its budget is +1.",
    ]


@pytest.mark.parametrize("text", ["coverage", "speed=1", "coverage=x", "coverage=1", "false=-1", "read=nan"])
def test_an_invalid_budget_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match="--budget"):
        budgets([text])
