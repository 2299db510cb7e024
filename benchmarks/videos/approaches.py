"""Simulated approaches as videos with ground truth, by stress."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from benchmarks.experiment import Data, Skip
from tsr_engine.evaluation.track_tables import read_mot_truth
from tsr_engine.track_table import TrackTable

EACH, EACH_OF_A_ROW, EACH_TUNED = 6, 2, 1
"""Number of approaches of each stress: for judging; for experiments with many rows; from the tuning set."""


@dataclass(frozen=True, slots=True)
class Approaches:
    """A folder of approaches.

    Attributes:
        seed: seed of the simulation.
        videos: clip -> (video, ground truth).
        stress: clip -> its stress.
        scenes: names of the photographs in the clips.
        hidden: clip -> frames in which a block covers its target and other signs; the ground truth marks only the
            target.
    """

    seed: int
    videos: dict[str, tuple[Path, TrackTable]]
    stress: dict[str, str]
    scenes: frozenset[str]
    hidden: dict[str, range]

    @property
    def stresses(self) -> tuple[str, ...]:
        """All stresses, by name."""
        return tuple(sorted(set(self.stress.values())))


def read_approaches(folder: Path, without: Iterable[str] = (), each: int | None = None) -> Approaches:
    """Read ``clips.json`` and the ground truth of each clip.

    Args:
        folder: folder with ``clips.json`` and a folder for each clip with ``video.mp4`` and ``gt.txt``.
        without: photographs whose clips are left out.
        each: number of first clips of each stress; unset: all.

    Raises:
        Skip: the folder holds no such list, or no clips remain.
    """
    index = folder / "clips.json"
    if not index.is_file():
        raise Skip(f"the folder `{folder.name}` of simulated approaches holds no clips.json.")
    about = json.loads(index.read_text(encoding="utf-8"))
    left_out = set(without)
    allowed = [clip for clip in about["clips"] if clip["image"] not in left_out]
    taken = Counter[str]()
    chosen = []
    for clip in allowed:
        taken[clip["stress"]] += 1
        if each is None or taken[clip["stress"]] <= each:
            chosen.append(clip)
    if not chosen:
        raise Skip(f"the folder `{folder.name}` of simulated approaches holds no clip of a scene that may be shown.")
    return Approaches(
        int(about["seed"]),
        {c["clip"]: (folder / c["clip"] / "video.mp4", read_mot_truth(folder / c["clip"] / "gt.txt")) for c in chosen},
        {c["clip"]: str(c["stress"]) for c in chosen},
        frozenset(str(c["image"]) for c in chosen),
        {c["clip"]: range(*c.get("hidden", (-1, -1))) for c in chosen},
    )


def judged_approaches(data: Data, each: int | None = None) -> Approaches:
    """The approaches of the folder ``looming``, without scenes of the folder ``tuning`` if that is given.

    Raises:
        Skip: there are none.
    """
    tuned = frozenset() if data.tuning is None else read_approaches(data.tuning).scenes
    return read_approaches(data.need("looming"), without=tuned, each=each)
