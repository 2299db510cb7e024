"""Compares following with the flow box, the closest peer, on every simulated approach."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from benchmarks.experiment import Data, Experiment, Result
from benchmarks.experiments.follow import TUNED_BOARDS
from benchmarks.following.figures import figures_of, mean_of, overlaps
from benchmarks.following.methods import KltBox, follow_with_engine, follow_with_peer
from benchmarks.following.visible_signs import POSITIONS, Sign, decode, signs_of
from benchmarks.reporting.markdown import table
from benchmarks.videos.approaches import judged_approaches, read_approaches
from tsr_engine.follow_video import load_follower
from tsr_engine.json_shapes import JsonObject
from tsr_engine.pipeline import one_blas_thread, one_opencv_thread
from tsr_engine.track_table import TrackTable

SIGNS = 3
"""Number of signs per video, the widest ones."""
ALL = "all"
OURS, PEER = "ours", "KLT"
BOARDS = "no label set"


def _videos(data: Data) -> Iterator[tuple[str, Path, TrackTable, range]]:
    approaches = judged_approaches(data)
    for name, (path, truth) in approaches.videos.items():
        yield approaches.stress[name], path, truth, approaches.hidden[name]
    if data.boards is not None:
        boards = read_approaches(data.boards, without=TUNED_BOARDS)
        for name, (path, truth) in boards.videos.items():
            yield BOARDS, path, truth, boards.hidden[name]


def _drawable(sign: Sign, hidden: range) -> Sign:
    """The sign without the frames in which a block covers it; ground truth lacks this for signs beside the target."""
    return replace(sign, clear=[k for k in sign.clear if k not in hidden])


def _run(data: Data) -> Result:
    parts = load_follower()
    rows: dict[str, dict[str, dict[str, list[dict[str, float]]]]] = defaultdict(
        lambda: {way: {position: [] for position in POSITIONS} for way in (OURS, PEER)}
    )
    with one_opencv_thread(), one_blas_thread():
        for group, path, truth, hidden in _videos(data):
            pictures = decode(path)
            height, width = pictures[0].shape[:2]
            for whole in signs_of(truth, width, height)[:SIGNS]:
                sign = _drawable(whole, hidden)
                if not sign.clear:
                    continue
                for position in POSITIONS:
                    start = sign.anchor(position)
                    for way, filled in (
                        (OURS, follow_with_engine(pictures, {start: sign.life[start]}, parts)),
                        (PEER, follow_with_peer(pictures, start, sign.life[start], KltBox)),
                    ):
                        iou = float(np.mean(list(overlaps(sign, filled.boxes).values())))
                        for of in (group, ALL):
                            rows[of][way][position].append({**figures_of(sign, filled.boxes), "iou": iou})
    groups = sorted(rows, key=lambda group: (group == ALL, group))
    figures = {
        group: {way: {p: mean_of(found) for p, found in by.items()} for way, by in rows[group].items()}
        for group in groups
    }
    return Result(
        data="All simulated approaches, under each stress, to scenes that no value was chosen on, and approaches to "
        f"signs of no label set in photographs that no value was chosen on. In each, the {SIGNS} signs that become "
        "widest are drawn where nothing occludes them.",
        figures=figures,
        settings={"opencv": cv2.__version__},
    )


def _report(result: Result) -> str:
    rows = [["", "signs", "", *POSITIONS]]
    below: list[str] = []
    for group, ways in result.figures.items():
        for way, by_position in ways.items():
            cells = [
                f"{f['iou70']:.3f} / {f['iou50']:.3f} / {f['iou']:.3f}; {f['ends_met']:.2f}; {f['runaway']:.2f}"
                for f in (by_position[p] for p in POSITIONS)
            ]
            rows.append([group, str(by_position["middle"]["starts"]), way, *cells])
        below += [f"{group}, {p} ({name})" for p in POSITIONS for name, worse in _worse(ways, p).items() if worse]
    return (
        "Share of frames with IoU >= 0.7 / >= 0.5 / mean IoU; ends met; runaways.\n\n"
        + table(rows)
        + "\nOurs is below the peer at: "
        + ("; ".join(below) if below else "none of these")
        + ".\n"
    )


def _worse(ways: JsonObject, position: str) -> dict[str, bool]:
    ours, peer = ways[OURS][position], ways[PEER][position]
    return {
        "IoU >= 0.7": ours["iou70"] < peer["iou70"],
        "mean IoU": ours["iou"] < peer["iou"],
        "ends": ours["ends_met"] < peer["ends_met"],
        "runaways": ours["runaway"] > peer["runaway"],
    }


EXPERIMENT = Experiment(
    "follow_approaches",
    "Following every approach",
    "The tables above have few signs of each stress, and the optical-flow tracker (KLT) comes near ours. How do both "
    "do on many signs?",
    _run,
    _report,
    optional=("tuning", "boards"),
)
