"""Compares parameters for the start of tracks, on videos that no reported figure uses.

    python -m benchmarks.tuning.confirmation --clips CLIPS --looming DIR --judged DIR [--setting NAME:key=value,...]...

Uses the real clips of the tuning set and simulated approaches to scenes that ``--judged`` does not show, at every,
every second, third and fourth frame. Runs ``default`` and the named settings, all without the online detector, since it
neither starts nor ends tracks. Prints signs found, tracks on no sign and coverage.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.experiments.frame_rates import HEADINGS, STEPS
from benchmarks.tuning.command_line import choice_parser, print_report
from benchmarks.tuning.stress import configurations
from benchmarks.videos.approaches import read_approaches
from benchmarks.videos.clips import CHOSEN_ON, read_clips
from benchmarks.videos.engine_tracker import filter_alone
from benchmarks.videos.stored_detections import AnnotatedVideo, DetectedVideo, detect_videos, every_nth_frame_of
from tsr_engine.evaluation.tracking import evaluate_video, summarise
from tsr_engine.params import Params

CLIPS, APPROACHES = "clips", "approaches"


def videos_of(clips: Path, looming: Path, judged: Path) -> list[AnnotatedVideo]:
    """The videos to use.

    Raises:
        Skip: there are none.
    """
    real = read_clips(clips)
    made = read_approaches(looming, without=read_approaches(judged).scenes)
    return [
        *(AnnotatedVideo(name, CLIPS, *real[name]) for name in CHOSEN_ON if name in real),
        *(AnnotatedVideo(name, APPROACHES, *video) for name, video in made.videos.items()),
    ]


def rows(videos: Sequence[DetectedVideo], chosen: Mapping[str, Params]) -> list[str]:
    """One line for each rate, group of videos and configuration."""
    width = max(map(len, chosen), default=0)
    lines = []
    for step in STEPS:
        left = [every_nth_frame_of(seen, step) for seen in videos]
        for group in (CLIPS, APPROACHES):
            for name, params in chosen.items():
                s = summarise(
                    evaluate_video(
                        seen.video.name, seen.video.truth, filter_alone(seen, params), len(seen.frames),
                        size=(seen.width, seen.height),
                    )
                    for seen in left if seen.video.group == group
                )  # fmt: skip
                lines.append(
                    f"{HEADINGS[str(step)]:12s}{group:12s}{name:{width}s}  {s.signs_detected}/{s.signs} signs, "
                    f"{s.false_tracks} false, coverage {s.coverage or 0:.4f}, {s.ids_per_sign or 0:.3f} ids"
                )
    return lines


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = choice_parser("tuning.confirmation", __doc__)
    parser.add_argument("--clips", type=Path, required=True, help="folder of real clips with gt/")
    parser.add_argument("--looming", type=Path, required=True, help="folder of simulated approaches")
    parser.add_argument("--judged", type=Path, required=True, help="approaches whose scenes are left out")
    args = parser.parse_args(argv)

    def compute(scratch: Path) -> str:
        chosen = {k: v for k, v in configurations(args.setting).items() if k not in ("KF alone", "paper")}
        seen = list(detect_videos(videos_of(args.clips, args.looming, args.judged), scratch))
        return "".join(f"{line}\n" for line in rows(seen, chosen))

    return print_report("tuning.confirmation", args.scratch, compute)


if __name__ == "__main__":
    sys.exit(main())
