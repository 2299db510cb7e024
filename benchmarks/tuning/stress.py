"""Tracking with the real detector on clips under stress: one row for each stress and configuration.

    python benchmarks/tuning/stress.py --clips DIR [--models DIR] [--first 24] [--setting NAME:key=value,...]...

``DIR`` holds ``clips.json`` (which names each clip and its stress) and a folder for each clip with ``video.mp4`` and
``gt.txt`` in MOTChallenge rows. Three configurations are run by default: ``default``, the Kalman filter alone, and
``paper``.
"""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path

from benchmarks.videos.tracked_rows import track_rows
from tsr_engine.evaluation.track_tables import read_mot_truth
from tsr_engine.evaluation.tracking import VideoReport, evaluate_video, summarise
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components

COLUMNS = ("signs", "found", "false", "ids", "coverage", "Eq. 7", "followed", "right")


def configurations(settings: list[str]) -> dict[str, Params]:
    """Name -> parameters: the default configurations, and further ones from ``NAME:key=value,...``.

    Raises:
        UsageError: a parameter is unknown, or a value is invalid.
    """
    found = {
        "default": Params.preset("default"),
        "KF alone": Params.preset("default").with_settings([("use_online", False)]),
        "paper": Params.preset("paper"),
    }
    for text in settings:
        name, _, changes = text.partition(":")
        # A comma separates two settings only if a name follows, since values may be lists.
        pairs = [change.partition("=") for change in re.split(r",(?=\w+=)", changes) if change]
        found[name] = Params.preset("default").with_settings([(key, value) for key, _, value in pairs])
    return found


def main() -> None:
    """Track, score and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--clips", type=Path, required=True)
    parser.add_argument("--models", type=Path)
    parser.add_argument("--first", type=int, help="number of first clips to use; unset: all")
    parser.add_argument("--setting", action="append", default=[], help="a further configuration")
    parser.add_argument("--only", action="append", help="only these configurations")
    args = parser.parse_args()
    clips = json.loads((args.clips / "clips.json").read_text(encoding="utf-8"))["clips"][: args.first]
    print(f"{'stress':14s}{'configuration':16s}" + "".join(f"{c:>10s}" for c in COLUMNS))
    reports: dict[tuple[str, str], list[VideoReport]] = {}
    chosen = {k: v for k, v in configurations(args.setting).items() if not args.only or k in args.only}
    for name, params in chosen.items():
        components = load_components(params, args.models)
        for clip in clips:
            folder = args.clips / clip["clip"]
            report, rows = track_rows(folder / "video.mp4", params, components)
            size = report.width, report.height
            scored = evaluate_video(clip["clip"], read_mot_truth(folder / "gt.txt"), rows, report.frames, size=size)
            for stress in (clip["stress"], "all"):
                reports.setdefault((stress, name), []).append(scored)
    for (stress, name), videos in sorted(reports.items(), key=lambda item: (item[0][0] == "all", item[0][0])):
        s = summarise(videos)
        counts = f"{s.signs:10d}{s.signs_detected:10d}{s.false_tracks:10d}{s.ids_per_sign or 0:10.3f}"
        errors = f"{s.coverage or 0:10.4f}{s.mean_error or 0:10.4f}{s.mean_error_followed or 0:10.4f}"
        print(f"{stress:14s}{name:16s}{counts}{errors}{s.signs_classified:10d}")


if __name__ == "__main__":
    main()
