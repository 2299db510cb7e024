"""Compares following a sign from one drawn box with generic trackers, a flow box and straight lines."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from benchmarks.cache import Cache, code, digest_of, file_digest, table_digest
from benchmarks.experiment import Data, Experiment, Result
from benchmarks.following.figures import MAX_ACTIONS, actions, figures_of, lines_needed, mean_of
from benchmarks.following.long_video import flat_memory
from benchmarks.following.methods import (
    PEERS,
    Filled,
    follow_with_engine,
    follow_with_peer,
    interpolate_linearly,
    peer_maker,
)
from benchmarks.following.visible_signs import POSITIONS, Sign, decode, paint_over, signs_of
from benchmarks.peers.detection_gaps import Follower
from benchmarks.peers.multi_object_trackers import Missing
from benchmarks.reporting.markdown import table
from benchmarks.videos.approaches import judged_approaches, read_approaches
from benchmarks.videos.clips import read_clips
from tsr_engine.follow import FollowerModels
from tsr_engine.follow_video import load_follower
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.pipeline import one_blas_thread, one_opencv_thread
from tsr_engine.records import FloatArray, Picture
from tsr_engine.track_table import TrackTable

TUNED_ON = ("02_71ec1e", "03_c0da85", "SH13_9f8bd8")
"""Clips that values of the follower were chosen on."""
TUNED_BOARDS = frozenset(f"{number:07d}.jpg" for number in (1, 3, 5, 7, 10, 12, 14, 16, 18, 20, 28, 44, 85, 1818))
"""Photographs of DFG with signs of no label set that values of the follower were chosen on."""
EACH = 1
"""Number of approaches of each stress, to signs of the 43 classes and to signs of no label set."""
SIGNS = 3
"""Number of signs per video, the widest ones; few, since peers take a tenth of a second per frame."""
SLOW = ("MIL", "TLD")
"""Peers that run only on approaches; on the pictures of clips they take 30 ms per frame and more."""
OURS = "ours"
UNKNOWN = "ours, no detector"
"""Name of our follower without the offline detector's later stages, as for a sign of unknown shape."""
LINES = (2, 3, 4)
GONE = "painted over"
CLIPS = "clips"


@dataclass(frozen=True, slots=True)
class _Video:
    group: str
    path: Path
    truth: TrackTable
    vanish: bool = False

    def digests(self) -> list[object]:
        return [self.group, file_digest(self.path), table_digest(self.truth), self.vanish]


def _videos(data: Data) -> Iterator[_Video]:
    for name, (path, truth) in read_clips(data.need("clips")).items():
        if name not in TUNED_ON:
            yield _Video(CLIPS, path, truth)
    approaches = judged_approaches(data, EACH)
    for name, (path, truth) in approaches.videos.items():
        yield _Video(approaches.stress[name], path, truth)
    for name, (path, truth) in approaches.videos.items():
        if approaches.stress[name] in ("steady", "shake"):
            yield _Video(GONE, path, truth, True)
    if data.boards is not None:
        for path, truth in read_approaches(data.need("boards"), without=TUNED_BOARDS, each=EACH).videos.values():
            yield _Video("no label set", path, truth)


def _run(data: Data) -> Result:
    parts = load_follower()
    makers: dict[str, Callable[[], Follower]] = {}
    missing: dict[str, str] = {}
    for name in PEERS:
        try:
            makers[name] = peer_maker(name)
        except Missing as why:
            missing[name] = str(why)
    cache = Cache(data.scratch / "following")
    root = Path(__file__).parents[1]
    own = digest_of(root, [root / "following" / f"{name}.py" for name in ("visible_signs", "methods", "figures")])
    engine = code(("follow", "follow_video.py"))
    long = digest_of(root, [root / "following" / "long_video.py"])
    rows: dict[str, dict[str, dict[str, list[dict[str, float]]]]] = {}
    needed: dict[str, list[dict[str, float]]] = {}
    signs: dict[str, int] = {}
    times: dict[str, list[tuple[float, int]]] = {}
    with one_opencv_thread(), one_blas_thread():  # so that the CPU time of a step is meaningful
        for video in _videos(data):
            about = [*video.digests(), own, cv2.__version__]
            ours = cache.get(["ours", *about, engine], partial(_ours, video, parts))
            able = {name: make for name, make in makers.items() if video.group != CLIPS or name not in SLOW}
            theirs = cache.get(["theirs", *about, sorted(able)], partial(_theirs, video, able))
            signs[video.group] = signs.get(video.group, 0) + ours["signs"]
            for way, by_position in {**ours["ways"], **theirs["ways"]}.items():
                for position, found in by_position.items():
                    rows.setdefault(video.group, {}).setdefault(way, {}).setdefault(position, []).extend(found)
            needed.setdefault(video.group, []).extend(ours["needed"])
            for way, (seconds, steps) in {**ours["times"], **theirs["times"]}.items():
                times.setdefault(way if video.group != CLIPS else f"{way} at 720p", []).append((seconds, steps))
    figures = {
        "groups": {
            group: {way: {p: mean_of(found) for p, found in by.items()} for way, by in ways.items()}
            for group, ways in rows.items()
        },
        "actions": {group: mean_of(found) for group, found in needed.items() if found},
        "ms": {way: 1e3 * sum(s for s, _ in found) / max(1, sum(n for _, n in found)) for way, found in times.items()},
        "memory": cache.get(["memory", long, engine], partial(flat_memory, parts, data.scratch)),
        "missing": missing,
    }
    return Result(
        data=f"Signs: {', '.join(f'{n} ({group})' for group, n in signs.items())}. Clips: annotated dash-cam clips "
        f"except {', '.join(TUNED_ON)}, which values were chosen on; with signs of all kinds, also of none of the 43 "
        "classes. The approaches are simulated and show scenes that no value was chosen on. *Painted over*: approaches "
        "whose sign vanishes in the middle of the picture. Times are CPU ms.",
        figures=figures,
        settings={"opencv": cv2.__version__},
    )


def _signs(video: _Video) -> Iterator[tuple[Sequence[Picture], Sign]]:
    pictures = decode(video.path)
    height, width = pictures[0].shape[:2]
    for sign in signs_of(video.truth, width, height)[:SIGNS]:
        yield paint_over(pictures, sign) if video.vanish else (pictures, sign)


class _Figures:
    """Figures and times of the ways to follow, over the signs of one video.

    Attributes:
        ways: way -> position of the first box -> figures for each sign.
        times: way -> CPU seconds and number of steps.
    """

    def __init__(self) -> None:
        self.ways: dict[str, dict[str, list[dict[str, float]]]] = {}
        self.times: dict[str, list[float]] = {}

    def add(self, way: str, position: str, sign: Sign, boxes: Mapping[int, FloatArray]) -> None:
        """Add the boxes of one sign."""
        self.ways.setdefault(way, {}).setdefault(position, []).append(figures_of(sign, boxes))

    def add_timed(self, way: str, position: str, sign: Sign, filled: Filled) -> None:
        """Add the boxes of one sign and their time."""
        self.add(way, position, sign, filled.boxes)
        seconds, steps = self.times.get(way, [0.0, 0])
        self.times[way] = [seconds + filled.seconds, steps + filled.steps]


def _ours(video: _Video, parts: FollowerModels) -> JsonObject:
    """Our figures on one video, and the number of boxes to draw for its signs."""
    found = _Figures()
    needed: list[dict[str, float]] = []
    for pictures, sign in _signs(video):
        for position in POSITIONS:
            start = sign.anchor(position)
            for way, given in ((OURS, parts), (UNKNOWN, FollowerModels(parts.make_online, None))):
                found.add_timed(way, position, sign, follow_with_engine(pictures, {start: sign.life[start]}, given))
        for k in LINES:
            frames = np.array(sorted(sign.life))
            chosen = frames[np.round(np.linspace(0, len(frames) - 1, k)).astype(int)].tolist()
            lines = interpolate_linearly({frame: sign.life[frame] for frame in chosen})
            found.add(f"lines, {k} exact boxes", "whole life", sign, lines)

        def fill(drawn: Mapping[int, FloatArray], pictures: Sequence[Picture] = pictures) -> Mapping[int, FloatArray]:
            return follow_with_engine(pictures, drawn, parts).boxes

        by_position = {position: float(actions(sign, sign.anchor(position), fill)) for position in POSITIONS}
        needed.append({**by_position, "lines": float(lines_needed(sign))})
    return {"ways": found.ways, "times": found.times, "needed": needed, "signs": len(needed)}


def _theirs(video: _Video, makers: Mapping[str, Callable[[], Follower]]) -> JsonObject:
    """The peers' figures on one video."""
    found = _Figures()
    for pictures, sign in _signs(video):
        for position in POSITIONS:
            start = sign.anchor(position)
            for name, make in makers.items():
                found.add_timed(name, position, sign, follow_with_peer(pictures, start, sign.life[start], make))
    return {"ways": found.ways, "times": found.times}


def _report(result: Result) -> str:
    f = result.figures
    parts = [_table(f["groups"], group) for group in f["groups"]]
    rows = [["", *POSITIONS, "straight lines"]]
    for group, found in f["actions"].items():
        rows.append([group, *(f"{found[p]:.2f}" for p in POSITIONS), f"{found['lines']:.2f}"])
    signs = [found["starts"] for found in f["actions"].values()]
    means = (np.average([found[p] for found in f["actions"].values()], weights=signs) for p in (*POSITIONS, "lines"))
    rows.append([f"all {sum(signs)} signs", *(f"{mean:.2f}" for mean in means)])
    m = f["memory"]
    parts += [
        "Average number of boxes to draw until every frame has an IoU of at least 0.7. The first box is drawn where "
        f"the column says, each further one where the result is worst, {MAX_ACTIONS} at most. With straight lines, "
        "exact boxes are drawn at both ends and where the line is worst.\n",
        table(rows),
        f"A frame of 1280x720 px takes {_ms(f['ms'], f'{OURS} at 720p')}, with the offline detector's later steps "
        "where they know the sign, without decoding. Peers: "
        + ", ".join(f"{name} {_ms(f['ms'], f'{name} at 720p')}" for name in PEERS if f"{name} at 720p" in f["ms"])
        + f".\n\nOver {m['frames']:,} frames of a video whose group of pictures is {m['group']} frames long, followed "
        f"backwards from its end, the process grows from {m['early_mb']:.0f} MB after {m['early']:,} frames to "
        f"{m['late_mb']:.0f} MB.\n",
    ]
    for name, why in f["missing"].items():
        parts.append(f"{name} is not there: {why}\n")
    return "\n".join(parts)


def _ms(times: Mapping[str, float], way: str) -> str:
    return f"{times[way]:.1f} ms ({1e3 / times[way]:.0f} frames/s)"


def _table(groups: JsonMapping, group: str) -> str:
    ways = groups[group]
    head = ["share of frames with IoU >= 0.7 / >= 0.5; ends met; runaways", *POSITIONS]
    rows = [head]
    for way, by_position in ways.items():
        if "whole life" in by_position:
            found = by_position["whole life"]
            rows.append([way, f"{found['iou70']:.3f} / {found['iou50']:.3f}", "", ""])
            continue
        best = {p: max(w[p]["iou70"] for w in ways.values() if p in w) for p in POSITIONS}
        cells = []
        for p in POSITIONS:
            found = by_position[p]
            share = f"{found['iou70']:.3f}"
            share = f"**{share}**" if found["iou70"] >= best[p] else share
            cells.append(f"{share} / {found['iou50']:.3f}; {found['ends_met']:.2f}; {found['runaway']:.2f}")
        rows.append([way, *cells])
    starts = next(iter(next(iter(ways.values())).values()))["starts"]
    return f"**{group}** ({starts} signs)\n\n{table(rows)}"


EXPERIMENT = Experiment(
    "follow",
    "Draw once, follow both ways",
    "A person draws a sign in one frame. In how many frames of its visible life is the followed box right, does it "
    "stop where the sign ends, and how many boxes does a person draw in all?",
    _run,
    _report,
    optional=("tuning", "boards"),
)
