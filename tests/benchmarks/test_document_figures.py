"""Pages that repeat figures of the report have those of the stored results."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest

from benchmarks.experiment import ROOT

FILTER = "the paper's KF alone"


def figures(experiment: str) -> Any:  # Any: figures have the shape of their experiment
    """Figures of an experiment."""
    return json.loads((ROOT / "results" / f"{experiment}.json").read_text(encoding="utf-8"))["figures"]


def follow() -> Iterator[str]:
    """Texts of the page about following."""
    found, boards = figures("follow"), figures("follow_approaches")["no label set"]
    memory, ours, klt = found["memory"], *(max(r["runaway"] for r in boards[t].values()) for t in ("ours", "KLT"))
    yield f"at 1280x720 on one core | {1000 / found['ms']['ours at 720p']:.0f} |"
    yield f"| {memory['early_mb']:.0f} MB after 5,000, {memory['late_mb']:.0f} MB after 10,000 |"
    yield f"{ours:.2f} of 71 in `follow_approaches` (KLT 1 of 9, {klt:.2f})"


def tracking() -> Iterator[str]:
    """Texts of the page about tracking."""
    kinds = {kind: value["rows"] for kind, value in figures("poor_detections")["kinds"].items()}
    both, misses = kinds["boxes off, runs of misses"], kinds["runs of misses"]
    paper = max(both, key=lambda row: int(row.removeprefix("paper, tau ")) if row.startswith("paper, tau ") else 0)
    yield f"on the engine's detections it has {kinds['as detected'][FILTER]['mean_error']:.3f}."
    yield f"tau of the paper's procedure, {paper.removeprefix('paper, tau ')} in"
    for rows in (misses, both):
        with_it, without = rows[paper]["mean_error_followed"], rows[FILTER]["mean_error_followed"]
        yield f"{with_it:.3f} instead of {without:.3f}"
    alone, online, default = both["KF alone"], both["default, no window rescoring"], both["default"]
    yield (
        f"Eq. 7 from {alone['mean_error']:.3f} to {online['mean_error']:.3f}, with window rescoring to "
        f"{default['mean_error']:.3f}; {100 * default['coverage']:.0f} % of the sign frames are covered instead of "
        f"{100 * alone['coverage']:.0f} %."
    )


def models() -> Iterator[str]:
    """Texts of the model card."""
    other, first = figures("other_shapes"), figures("first_sight")["sample drives"]
    scenes, price, (low, high) = other["foreign"]["dfg_half"], other["price"], first["interval"]
    found, without = scenes["with"]["other_at_rate"], scenes["without"]["other_at_rate"]
    yield f"it finds {found} with the option and {without} without; at a threshold"
    yield f"a picture takes {price['with']:.0f} ms instead of {price['without']:.0f} on one"
    yield f"the detector before the shipped one | {first['ratio']:.2f} (95 %: {low:.2f} to {high:.2f}) |"


def retraining() -> Iterator[str]:
    """Texts of the page about retraining."""
    clear, dim = figures("retraining")["as filmed"], figures("retraining")["dim camera"]
    before, after, scenes = clear["before"], clear["after"], clear["gtsdb"]
    yield (
        f"falls from {before['mean_eq7']:.3f} to {after['mean_eq7']:.3f} in single frames and from "
        f"{before['mean_error']:.3f} to {after['mean_error']:.3f} in tracks"
    )
    yield f"less exact ({scenes['parent']['mean_eq7']:.3f} to {scenes['new']['mean_eq7']:.3f})"
    before, after = dim["before"], dim["after"]
    yield f"**AP rises from {before['ap50']:.3f} to {after['ap50']:.3f} with the dim camera.**"
    yield f"(Eq. 7 of tracks {before['mean_error']:.3f} to {after['mean_error']:.3f})"
    yield f"Tracks cover more ({before['coverage']:.3f} to {after['coverage']:.3f} of the frames)"


def scale() -> Iterator[str]:
    """Texts of the page about scale."""
    databases = figures("search")["databases"]
    seconds = {name: f"{database['fill_seconds']:.0f}" for name, database in databases.items()}
    yield f"{seconds['PostgreSQL']} s a million tracks in PostgreSQL, {seconds['SQLite']} s in SQLite"


@pytest.mark.parametrize("texts", [follow, tracking, models, retraining, scale], ids=lambda texts: texts.__name__)
def test_a_page_has_the_figures_of_the_results(texts: Any) -> None:  # Any: a function of this module
    page = " ".join((ROOT.parent / "docs" / f"{texts.__name__}.md").read_text(encoding="utf-8").split())
    assert [text for text in texts() if text not in page] == []
