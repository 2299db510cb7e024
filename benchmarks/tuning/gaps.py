"""Compares parameters in gaps without detections, on videos that no reported figure uses.

    python -m benchmarks.tuning.gaps --clips CLIPS [--setting NAME:key=value,...]...
    python -m benchmarks.tuning.gaps --looming DIR --judged DIR [--every 3] [--setting NAME:key=value,...]...

The first command uses the real clips of the tuning set, with six frames between two starts on a sign. The second uses
simulated approaches to scenes that ``--judged`` does not show, with ten frames between. Runs ``default``, the filter
alone and the named settings. Prints Eq. 7 and the share of signs held at IoU 0.5 after each gap.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Mapping, Sequence
from itertools import islice
from pathlib import Path

from benchmarks.peers.detection_gaps import LENGTHS, Outcome, find_gaps, our_outcomes, summary
from benchmarks.tuning.command_line import choice_parser, print_report
from benchmarks.tuning.stress import configurations
from benchmarks.videos.approaches import read_approaches
from benchmarks.videos.clips import CHOSEN_ON, read_clips
from benchmarks.videos.stored_detections import AnnotatedVideo, DetectedVideo, detect_videos, pictures
from tsr_engine.params import Params
from tsr_engine.pipeline import Components, load_components

EVERY_ON_CLIPS, EVERY_ON_APPROACHES = 6, 10
"""Number of frames between two starts on a sign."""


def outcomes_of(
    videos: Iterable[DetectedVideo], chosen: Mapping[str, tuple[Params, Components]], every: int
) -> dict[str, list[Outcome]]:
    """The outcome of each configuration at the end of each gap.

    Args:
        videos: videos with their detections.
        chosen: name -> parameters and the engine's parts.
        every: least number of frames between two starts on a sign.
    """
    found: dict[str, list[Outcome]] = {name: [] for name in chosen}
    for seen in videos:
        gaps = find_gaps(seen, every)
        shown = [picture for _, picture in pictures(seen)] if gaps else []
        for gap in gaps:
            for name, (params, components) in chosen.items():
                found[name] += our_outcomes(seen, shown, gap, seen.with_focus(params), components.parts)[0]
    return found


def rows(found: Mapping[str, Sequence[Outcome]]) -> str:
    """One line for each configuration."""
    width = max(map(len, found), default=0)
    lines = []
    for name, outcomes in found.items():
        cells = [f"{name:{width}s}"]
        for length in LENGTHS:
            report = summary(outcomes, length)
            if report["gaps"]:
                cells.append(f"{length:4d} frames: {report['error']:.4f}, {report['held']:6.1%} of {report['gaps']}")
        lines.append("  ".join(cells))
    return "\n".join(lines)


def videos_of(args: argparse.Namespace) -> tuple[list[AnnotatedVideo], int]:
    """The videos to use, and the number of frames between two starts.

    Raises:
        Skip: there are none.
    """
    if args.clips is not None:
        clips = read_clips(args.clips)
        return [AnnotatedVideo(name, "chosen on", *clips[name]) for name in CHOSEN_ON if name in clips], EVERY_ON_CLIPS
    found = read_approaches(args.looming, without=read_approaches(args.judged).scenes)
    taken = islice(found.videos.items(), 0, None, args.every)
    return [AnnotatedVideo(name, found.stress[name], *video) for name, video in taken], EVERY_ON_APPROACHES


def parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """The command line."""
    parser = choice_parser("tuning.gaps", __doc__)
    data = parser.add_mutually_exclusive_group(required=True)
    data.add_argument("--clips", type=Path, help="folder of real clips with gt/")
    data.add_argument("--looming", type=Path, help="folder of simulated approaches")
    parser.add_argument("--judged", type=Path, help="approaches whose scenes are left out")
    parser.add_argument("--every", type=int, default=1, help="take every n-th approach")
    args = parser.parse_args(argv)
    if args.looming is not None and args.judged is None:
        parser.error("--looming needs --judged: approaches that figures are reported on must be left out.")
    if args.every < 1:
        parser.error(f"--every must be 1 or more. Got {args.every} instead.")
    return args


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table."""
    args = parse(argv)

    def compute(scratch: Path) -> str:
        named = configurations(args.setting)
        chosen = {name: (params, load_components(params)) for name, params in named.items() if name != "paper"}
        videos, every = videos_of(args)
        return f"{rows(outcomes_of(detect_videos(videos, scratch), chosen, every))}\n"

    return print_report("tuning.gaps", args.scratch, compute)


if __name__ == "__main__":
    sys.exit(main())
