"""Real annotated clips, by name and by use."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

from benchmarks.experiment import Skip
from tsr_engine.evaluation.track_tables import read_clip_truth
from tsr_engine.track_table import TrackTable

T = TypeVar("T")
CHOSEN_ON = ("01_076852", "SH4_70b651", "SK3_38cde7")
"""Clips that parameters were chosen on; the others are held out."""
SAME_PLACE = ("02_71ec1e", "03_c0da85")
"""Clips of one place: two signs occur in both."""


def read_clips(folder: Path) -> dict[str, tuple[Path, TrackTable]]:
    """Annotated clips of a folder by name, each with its ground truth.

    Raises:
        Skip: there are no clips.
    """
    found = {
        path.stem: (folder / f"{path.stem}.mp4", read_clip_truth(path))
        for path in sorted((folder / "gt").glob("*.csv"))
        if (folder / f"{path.stem}.mp4").is_file()
    }
    if not found:
        raise Skip("the folder `clips` holds no annotated clip.")
    return found


def place_of(clip: str) -> str:
    """Place of a clip: clips of one place share signs, so that they belong to the same fold."""
    return SAME_PLACE[0] if clip in SAME_PLACE else clip


def clip_groups(clips: Mapping[str, T]) -> dict[str, dict[str, T]]:
    """The held-out clips, and those that parameters were chosen on, by name; an empty group is left out."""
    groups: dict[str, dict[str, T]] = {"held out": {}, "chosen on": {}}
    for name, clip in clips.items():
        groups["chosen on" if name in CHOSEN_ON else "held out"][name] = clip
    return {group: members for group, members in groups.items() if members}
