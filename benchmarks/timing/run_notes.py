"""Reads the notes of a long run: rate and memory by section."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Section:
    """A part of a run.

    Attributes:
        frames: number of frames done at its end.
        per_second: frames per second of wall time.
        cpu_ms: CPU time per frame of all threads, ms.
        peak_mb: peak of resident memory up to its end, without pictures that only the measurement needs.
        sittings: number of processes of the run up to its end.
    """

    frames: int
    per_second: float
    cpu_ms: float
    peak_mb: float
    sittings: int


def read_sections(path: Path, ends: Sequence[int]) -> list[Section]:
    """Sections that end at the given numbers of frames, up to the end of the run.

    Only the time between two notes of the same process counts, so pauses and starts of processes are not included. A
    run that ended before the first given number has one section.
    """
    steps: list[tuple[int, int, float, float]] = []
    peaks: list[tuple[int, float, int]] = []
    held, sitting, before = 0.0, 0, None
    for line in path.read_text(encoding="utf-8").splitlines() if path.is_file() else []:
        note = json.loads(line)
        if "held_mb" in note:
            held, before, sitting = note["held_mb"], None, sitting + 1
            continue
        peaks.append((note["frames"], note["peak_mb"] - held, sitting))
        if before is not None:
            steps.append((
                note["frames"], note["frames"] - before["frames"], note["wall"] - before["wall"],
                note["cpu"] - before["cpu"],
            ))  # fmt: skip
        before = note
    if not steps:
        return []
    last = steps[-1][0]
    wanted = [end for end in ends if end <= last]
    if not wanted or wanted[-1] < last:
        wanted.append(last)
    sections, start = [], 0
    for end in wanted:
        inside = [step for step in steps if start < step[0] <= end]
        start = end
        frames, wall, cpu = (sum(step[i] for step in inside) for i in (1, 2, 3))
        if not frames:
            continue
        peak = max(mb for at, mb, _ in peaks if at <= end)
        sittings = max(number for at, _, number in peaks if at <= end)
        sections.append(Section(end, frames / wall, 1e3 * cpu / frames, peak, sittings))
    return sections
