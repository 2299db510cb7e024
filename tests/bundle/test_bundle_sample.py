"""A bundle of the sample drive with the shipped models: still broken, fixed with other settings, different."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from sample_videos import SHIPPED
from tests.bundle.tracked_drive import make_expectation
from tsr_engine.bundle import BundleRequest, bundle_params, make_bundle, open_bundle, replay_bundle
from tsr_engine.evidence import EvidenceReader
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components
from tsr_engine.runs.track_video import RunRequest, track_video


@pytest.mark.slow
def test_the_sample_drive(tmp_path: Path) -> None:
    params = Params().with_settings([("coast_foe_y", 0.5)])
    components = load_components(params)
    track_video(RunRequest(SHIPPED[0].video, params, tmp_path / "run", stop=14), components)
    with EvidenceReader(tmp_path / "run") as reader:
        seen = [row for row in reader.result_rows() if row.track_id == 1 and 8 <= row.frame < 14]
    frames, boxes = [row.frame for row in seen], [row[2:6] for row in seen]
    assert frames == list(range(8, 14))
    wrong = next(label for label in range(43) if label != seen[0].class_id)
    sign: dict[str, Any] = {"s": {"frames": frames, "boxes": boxes}}

    def verdict(expected: list[dict[str, Any]], *settings: tuple[str, object]) -> tuple[str, int | None]:
        asked = make_expectation(signs=sign, expected=expected)
        made = make_bundle(
            BundleRequest(
                tmp_path / "run", SHIPPED[0].video, tmp_path / "bug.zip", 8, 14, expectation=asked, recording=False
            )
        )
        assert "ship with the package" in made.manifest.models
        with open_bundle(made.path) as bundle:
            stored, _ = bundle_params(bundle)
            report = replay_bundle(bundle, stored.with_settings(settings), components)
        return report.verdict, report.identical

    label = {"id": "label", "kind": "label", "sign": "s", "class_id": wrong}
    absent = {"id": "absent", "kind": "absent", "sign": "s"}
    found = {"id": "found", "kind": "found", "sign": "s"}
    assert verdict([label]) == ("still broken", 6)
    assert verdict([absent], ("birth_score", 1e6))[0] == "fixed"
    assert verdict([absent, found], ("birth_score", 1e6))[0] == "different"
    assert json.loads((tmp_path / "run" / "run.json").read_text())["state"] == "complete"
