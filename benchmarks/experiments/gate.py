"""Fig. 8: the choice of tau by the rate of correctly collected candidates."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.experiment import Data, Experiment, Result, Skip
from benchmarks.reporting.plotting import saved_figure
from benchmarks.videos.clips import clip_groups
from tsr_engine.evaluation.gate import Candidates, Trial, collection_curve, gate_trials
from tsr_engine.evaluation.track_tables import read_clip_truth
from tsr_engine.io.video import open_video
from tsr_engine.params import Params
from tsr_engine.params.gate import GateParams
from tsr_engine.records import FloatArray
from tsr_engine.track_table import TrackTable

TAU = np.geomspace(0.5, 500, 121)


def trials_of(video: Path, truth: TrackTable, params: GateParams, candidates: Candidates, seed: int) -> list[Trial]:
    """Trials of the gate around the counted signs of a video, see :func:`tsr_engine.evaluation.gate.gate_trials`."""
    boxes: dict[int, dict[int, FloatArray]] = {}
    for row in np.flatnonzero(~truth.ignore):
        boxes.setdefault(int(truth.frame[row]), {})[int(truth.track[row])] = truth.boxes[row]
    with open_video(video) as opened:
        frames = ((frame.ordinal, frame.picture) for frame in opened.frames())
        return list(gate_trials(frames, boxes, params, candidates, seed))


def _trials(clips: Path, params: Params, seed: int) -> dict[str, list[tuple[str, Trial]]]:
    found: dict[str, list[tuple[str, Trial]]] = {}
    for path in sorted((clips / "gt").glob("*.csv")):
        video = clips / f"{path.stem}.mp4"
        if not video.is_file():
            continue
        trials = trials_of(video, read_clip_truth(path), params.gate, Candidates(), seed)
        found[path.stem] = [(path.stem, trial) for trial in trials]
    if len(found) < 2:
        raise Skip("the folder `clips` holds fewer than two annotated clips.")
    return found


def _run(data: Data) -> Result:
    params = Params.preset("default")
    by_clip = _trials(data.need("clips"), params, data.seed)
    names = sorted(by_clip)
    # The best tau of each half is judged on the other half. Clips that show the same signs are in the same half: those
    # held out, and those that parameters were chosen on.
    groups = [list(group) for group in clip_groups(by_clip).values()]
    halves = (groups[0], groups[1]) if len(groups) == 2 else (names[::2], names[1::2])
    judged = []
    for mine, others in (halves, halves[::-1]):
        best = collection_curve([t for n in mine for t in by_clip[n]], TAU).best_tau
        other = collection_curve([t for n in others for t in by_clip[n]], TAU)
        judged.append({"tau": best, "correct": float(np.interp(best, other.tau, other.correct))})
    curve = collection_curve([t for n in names for t in by_clip[n]], TAU)
    return Result(
        data=f"Candidates around the annotated signs of {len(names)} clips. The tau chosen on {', '.join(halves[0])} "
        f"is tested on {', '.join(halves[1])}, and vice versa.",
        figures={
            "tau": curve.tau.tolist(),
            "genuine": curve.genuine.tolist(),
            "patches": curve.patches.tolist(),
            "correct": curve.correct.tolist(),
            "judged": judged,
            "in_use": params.gate.tau,
            "correct_in_use": float(np.interp(params.gate.tau, curve.tau, curve.correct)),
            "best": curve.best_tau,
            "correct_at_15": float(np.interp(15.0, curve.tau, curve.correct)),
        },
        settings={"seed": data.seed},
    )


def _report(result: Result) -> str:
    f = result.figures
    held = " and ".join(f"{j['correct']:.3f} (tau {j['tau']:.1f})" for j in f["judged"])
    return (
        f"Correct collection rate of a tau chosen on other clips: {held}. The engine's tau, {f['in_use']:g}, reaches "
        f"{f['correct_in_use']:.3f} over all clips. The best tau there is {f['best']:.1f}. The paper's tau, "
        f"15, chosen on its own pictures, reaches {f['correct_at_15']:.3f} here.\n"
    )


def _plot(result: Result, path: Path) -> None:
    f = result.figures
    with saved_figure(path) as axes:
        axes.semilogx(f["tau"], f["correct"], label="correctly collected", linewidth=2)
        axes.semilogx(f["tau"], f["genuine"], "--", label="signs taken")
        axes.semilogx(f["tau"], f["patches"], ":", label="background refused")
        axes.axvline(f["in_use"], color="#999999", linewidth=1, label=f"in use: {f['in_use']:g}")
        axes.set(xlabel="tau", ylabel="rate", ylim=(0, 1.02))
        axes.legend()


EXPERIMENT = Experiment(
    "gate",
    "The choice of tau (Fig. 8)",
    "Which tau accepts the predictions of a sign and rejects the windows around it?",
    _run,
    _report,
    _plot,
)
