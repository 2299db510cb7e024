"""Simulated approaches with exact truth, one row a stress."""

from __future__ import annotations

import json

from benchmarks.experiment import Data, Experiment, Result, machine, table
from benchmarks.experiments.tracked import CONFIGURATIONS, score
from tsr_engine.evaluation.tracking import summarise
from tsr_engine.evaluation.tracking_rows import read_mot_truth

__all__ = ["EXPERIMENT"]

MOST = 24


def _run(data: Data) -> Result:
    folder = data.need("looming")
    clips = json.loads((folder / "clips.json").read_text(encoding="utf-8"))["clips"][:MOST]
    videos = {
        c["clip"]: (folder / c["clip"] / "video.mp4", read_mot_truth(folder / c["clip"] / "gt.txt")) for c in clips
    }
    stress_of = {c["clip"]: c["stress"] for c in clips}
    figures: dict[str, dict[str, object]] = {}
    for name, params in CONFIGURATIONS.items():
        reports, _ = score(videos, params)
        for stress in (*sorted(set(stress_of.values())), "all"):
            chosen = [r for r in reports if stress in ("all", stress_of[r.name])]
            figures.setdefault(stress, {})[name] = summarise(chosen).as_dict()
    return Result(
        "stress",
        data=f"{len(clips)} simulated approaches: signs and scenes are real pictures, the motion is exact. The scenes "
        "are among those that the detector was trained on, so detection is easier than on new roads; localisation and "
        "identity are what this measures.",
        figures=figures,
        settings={"clips": len(clips)},
        machine=machine(),
    )


def _tell(result: Result) -> str:
    rows = [["stress", "", "signs found", "false tracks", "ids per sign", "coverage", "mean Eq. 7", "right class"]]
    for stress, by_name in sorted(result.figures.items(), key=lambda item: (item[0] == "all", item[0])):
        for name, s in by_name.items():
            found = f"{s['signs_detected']}/{s['signs']}"
            rows.append([
                stress if name == "default" else "", name, found, str(s["false_tracks"]),
                "-" if s["ids_per_sign"] is None else f"{s['ids_per_sign']:.2f}",
                "-" if s["coverage"] is None else f"{s['coverage']:.3f}",
                "-" if s["mean_error"] is None else f"{s['mean_error']:.4f}",
                f"{s['signs_classified']}/{s['signs_detected']}",
            ])  # fmt: skip
    return table(rows)


EXPERIMENT = Experiment(
    "stress",
    "Under stress",
    "Does each departure from the paper hold where the drive is hard: shake, turns, gaps, blur, changing light?",
    _run,
    _tell,
)
