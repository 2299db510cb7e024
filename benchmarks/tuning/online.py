"""Compares parameters of the online detector for signs that are lost, on videos that no reported figure uses.

    python -m benchmarks.tuning.online --looming DIR... --judged DIR [--setting NAME:key=value,...]...

Uses simulated approaches to scenes that ``--judged`` does not show. Runs ``default``, the filter alone and the named
settings, all on the same detections. Prints one line for each stress and configuration: coverage, mean Eq. 7, and the
number of boxes that the online detector changed, with their Eq. 7 with and without it.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from benchmarks.tuning.command_line import choice_parser, print_report
from benchmarks.tuning.stress import configurations
from benchmarks.videos.approaches import read_approaches
from benchmarks.videos.stored_detections import AnnotatedVideo, DetectedVideo, detect_videos
from benchmarks.videos.tracked_clips import report_of, track_together
from tsr_engine.evaluation.tracking import VideoReport, changed_errors, summarise
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components

ALONE = "KF alone"
ALL = "all"

Reports = dict[str, dict[str, list[VideoReport]]]
"""Stress -> configuration -> one report for each video."""


def videos_of(folders: Iterable[Path], judged: Path) -> list[AnnotatedVideo]:
    """Approaches of all folders, without those that show a judged scene.

    Raises:
        Skip: there are none.
    """
    scenes = read_approaches(judged).scenes
    found = [(folder.name, read_approaches(folder, without=scenes)) for folder in folders]
    return [
        AnnotatedVideo(f"{folder}/{name}", made.stress[name], *video)
        for folder, made in found
        for name, video in made.videos.items()
    ]


def reports_of(videos: Iterable[DetectedVideo], chosen: Mapping[str, Params]) -> Reports:
    """Reports of every configuration on every video, by stress and in total."""
    parts = {name: load_components(params) for name, params in chosen.items()}
    found: Reports = {}
    for seen in videos:
        runs = track_together(seen, chosen, parts)
        for name, run in runs.items():
            report = report_of(seen, run)
            for stress in (seen.video.group, ALL):
                found.setdefault(stress, {}).setdefault(name, []).append(report)
    return found


def rows(reports: Reports) -> list[str]:
    """One line for each stress and configuration."""
    lines = []
    for stress in sorted(reports, key=lambda stress: (stress == ALL, stress)):
        by_name = reports[stress]
        width = max(map(len, by_name))
        for name, found in by_name.items():
            s, changed = summarise(found), changed_errors(found, by_name[ALONE])
            line = f"{stress:14s}{name:{width}s}  coverage {s.coverage or 0:.4f}, Eq. 7 {s.mean_error or 0:.4f}"
            if changed["n"]:
                line += f", {changed['n']} boxes changed: {changed['ours']:.4f}, without {changed['theirs']:.4f}"
            lines.append(line)
    return lines


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = choice_parser("tuning.online", __doc__)
    parser.add_argument("--looming", type=Path, required=True, nargs="+", help="folders of simulated approaches")
    parser.add_argument("--judged", type=Path, required=True, help="approaches whose scenes are left out")
    args = parser.parse_args(argv)

    def compute(scratch: Path) -> str:
        chosen = {name: params for name, params in configurations(args.setting).items() if name != "paper"}
        seen = detect_videos(videos_of(args.looming, args.judged), scratch)
        return "".join(f"{line}\n" for line in rows(reports_of(seen, chosen)))

    return print_report("tuning.online", args.scratch, compute)


if __name__ == "__main__":
    sys.exit(main())
