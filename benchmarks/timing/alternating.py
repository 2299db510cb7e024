"""Alternates contenders within one process, so that other load of the machine affects all of them."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tsr_engine.io.video import open_video
from tsr_engine.params import Params
from tsr_engine.pipeline import Components
from tsr_engine.records import FloatArray, Picture
from tsr_engine.runs.track_video import Progress, RunRequest, track_video

Contender = Callable[[Picture], object]
_STARTING = 12
"""Number of first frames of a drive that are not counted: they compile code and fill the decoder's queue."""


@dataclass(slots=True)
class Turns:
    """CPU times, ms, by contender.

    Attributes:
        ms: a list for each contender, in the order of the pictures.
        signs_in_view: mean number of tracks per frame, for a tracked drive.
    """

    ms: dict[str, list[float]] = field(default_factory=dict)
    signs_in_view: float = 0.0

    @property
    def names(self) -> tuple[str, ...]:
        """The contenders, in their order."""
        return tuple(self.ms)

    def add(self, name: str, seconds: float) -> None:
        """Add a time."""
        self.ms.setdefault(name, []).append(1e3 * seconds)

    def median(self, name: str) -> float:
        """Median time, ms."""
        return float(np.median(self.ms[name]))

    def summary(self, name: str) -> dict[str, float]:
        """Number of times, median, quartiles and mean, ms."""
        values = np.array(self.ms[name])
        return {"turns": len(values), **_quartiles(values, 3), "mean": round(float(values.mean()), 3)}

    def paired(self, one: str, other: str) -> dict[str, float]:
        """Median and quartiles of the ratio of two contenders' times on the same picture."""
        return _quartiles(np.array(self.ms[one]) / np.array(self.ms[other]), 4)


def _quartiles(values: FloatArray, digits: int) -> dict[str, float]:
    low, median, high = (round(float(value), digits) for value in np.percentile(values, [25, 50, 75]))
    return {"median": median, "low": low, "high": high}


def scenes_in_turn(contenders: Mapping[str, Contender], pictures: Sequence[Picture], rounds: int = 1) -> Turns:
    """Run every contender on every picture; the order rotates.

    Times are those of the calling thread, so contenders must not use other threads. If a contender has an attribute
    ``prepare``, it is called with the picture before, without timing.

    Args:
        contenders: contenders by name.
        pictures: pictures to process.
        rounds: runs of each contender on each picture; the shortest time counts, because load on neighbouring cores can
            double a single time.
    """
    turns = Turns({name: [] for name in contenders})
    names = list(contenders)
    for name in names:
        _prepare(contenders[name], pictures[0])
        contenders[name](pictures[0])  # compiles and allocates memory
    for number, picture in enumerate(pictures):
        least = dict.fromkeys(names, np.inf)
        for turn in range(rounds):
            first = (number + turn) % len(names)
            for name in names[first:] + names[:first]:
                _prepare(contenders[name], picture)
                least[name] = min(least[name], thread_seconds(contenders[name], picture))
        for name in names:
            turns.add(name, least[name])
    return turns


def pipeline_beside(
    video: Path, params: Params, components: Components, others: Mapping[str, tuple[Contender, int]]
) -> Turns:
    """Run the whole engine over a video, with other contenders between its frames.

    The engine's time of a frame is that of the whole process, with the decoding thread, minus that of the others.

    Args:
        video: the file.
        params: parameters of the run.
        components: trained parts for those parameters.
        others: name -> contender, and the number of frames between its runs.
    """
    turns = Turns({"whole engine": [], **{name: [] for name in others}})
    with open_video(video) as opened:
        still = next(iter(opened.frames(0, 1))).picture
    for work, _ in others.values():
        _prepare(work, still)
        work(still)
    before, theirs = time.process_time(), 0.0

    def after(progress: Progress) -> None:
        # Only the time of the others is subtracted; concurrent work of the decoding thread counts for the next frame.
        nonlocal before, theirs
        now = time.process_time()
        if progress.done > _STARTING:
            turns.add("whole engine", now - before - theirs)
        before, theirs = now, 0.0
        for name, (work, every) in others.items():
            if progress.done > _STARTING and progress.done % every == 0:
                seconds = thread_seconds(work, still)
                turns.add(name, seconds)
                theirs += seconds

    report = track_video(RunRequest(video, params), components, progress=after)
    turns.signs_in_view = sum(sum(t.frames.values()) for t in report.tracks) / max(1, report.frames)
    return turns


def _prepare(work: Contender, picture: Picture) -> None:
    prepare = getattr(work, "prepare", None)
    if prepare is not None:
        prepare(picture)


def thread_seconds(work: Contender, picture: Picture) -> float:
    """Processor time of this thread for one picture, seconds."""
    began = time.thread_time()
    work(picture)
    return time.thread_time() - began
