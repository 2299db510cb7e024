"""Checks that the queue's percentage is the probability of a change by a person, and that such tracks come first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sklearn.linear_model import LogisticRegression
from sklearn.metrics import brier_score_loss, log_loss, roc_auc_score

from app.evidence.tracks import TrackProperties
from app.evidence.uncertainty import WEIGHTS, UncertaintyInput, terms
from benchmarks.experiment import Data, Experiment, Result
from benchmarks.reporting.markdown import table
from benchmarks.reporting.plotting import saved_figure
from benchmarks.review.changed_tracks import CAMERAS, RUNS, JudgedRun, film, judged_runs
from benchmarks.videos.approaches import read_approaches
from benchmarks.videos.clips import place_of, read_clips
from tsr_engine.json_shapes import JsonMapping

NAMES = tuple(name for name in WEIGHTS if name != "constant")
EDGES = (0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 0.9, 1.0)
"""Edges of the bins of the reliability table."""
WAYS = ("fitted", "former")


@dataclass(frozen=True, slots=True)
class JudgedTracks:
    """All tracks, one entry for each.

    Attributes:
        terms: shape (n, 5), terms of the logistic regression.
        former: shape (n,), earlier sort key of the queue.
        changed: shape (n,), whether a person changes the track.
        clip: clip of the track.
        run: run of the track, a name in ``RUNS``.
        why: reason as in :class:`~benchmarks.review.changed_tracks.JudgedRun`.
    """

    terms: NDArray[np.float64]
    former: NDArray[np.float64]
    changed: NDArray[np.bool_]
    clip: NDArray[np.str_]
    run: NDArray[np.str_]
    why: tuple[str, ...]

    @classmethod
    def of(cls, runs: Sequence[JudgedRun]) -> JudgedTracks:
        """The tracks for which the ground truth tells whether they are changed."""
        known = [np.array([change is not None for change in run.changes], bool) for run in runs]
        whole = list(zip(runs, known, strict=True))
        why = tuple(change for run in runs for change in run.changes if change is not None)
        return cls(
            np.concatenate([_terms(run.properties)[keep] for run, keep in whole]),
            np.concatenate([_former(run)[keep] for run, keep in whole]),
            np.array([change != "" for change in why]),
            np.repeat([run.clip for run in runs], [int(keep.sum()) for keep in known]),
            np.repeat([run.run for run in runs], [int(keep.sum()) for keep in known]),
            why,
        )


def fit(terms_of: NDArray[np.float64], changed: NDArray[np.bool_]) -> LogisticRegression:
    """Fit the logistic regression over the terms."""
    return LogisticRegression(C=1.0, max_iter=1000).fit(terms_of, changed)


def held_out(judged: JudgedTracks) -> NDArray[np.float64]:
    """Probability of each track by a regression without the tracks of its clip's place, shape (n,)."""
    found = np.zeros(len(judged.changed))
    places = np.array([place_of(clip) for clip in judged.clip])
    for place in np.unique(places):
        own = places == place
        found[own] = fit(judged.terms[~own], judged.changed[~own]).predict_proba(judged.terms[own])[:, 1]
    return found


def _terms(tracks: TrackProperties) -> NDArray[np.float64]:
    given = UncertaintyInput(
        frames=tracks.frames,
        detected=tracks.detected,
        name=[],
        share=tracks.share,
        runner_up=[],
        runner_up_share=tracks.runner_up_share,
        rejected=tracks.rejected,
        judged=tracks.judged,
        windows=tracks.windows,
        by_engine=True,
    )
    found = terms(given)
    return np.stack([found[name] for name in NAMES], axis=1)


def _former(run: JudgedRun) -> NDArray[np.float64]:
    """The sort key of the queue up to version 0.1, without its term for verdicts near tau."""
    tracks = run.properties
    lead = tracks.share - np.nan_to_num(tracks.runner_up_share)
    predicted = (tracks.frames - tracks.detected - tracks.relocalised) / tracks.frames
    weights = (
        np.where(np.isnan(lead), 1.0, np.clip(1 - lead / 0.6, 0, 1)),
        0.7 * np.clip((15 - tracks.frames) / 12, 0, 1),
        0.6 * np.clip(predicted / 0.6, 0, 1),
        run.disagreement.weight,
    )
    return np.asarray(1 - np.prod([1 - weight for weight in weights], axis=0))


def _run(data: Data) -> Result:
    clips, approaches = read_clips(data.need("clips")), read_approaches(data.need("looming")).videos
    store = data.scratch / "changed"
    cameras = tuple(CAMERAS)
    videos = list(film(clips, store, cameras))
    for number, (name, approach) in enumerate(approaches.items()):
        videos += film({name: approach}, store, (cameras[number // 6 % len(cameras)],))
    judged = JudgedTracks.of(list(judged_runs(videos, store)))
    chances = {"fitted": held_out(judged), "former": judged.former}
    whole = fit(judged.terms, judged.changed)
    constant = float(whole.intercept_[0])
    return Result(
        data=f"{len(judged.changed)} confirmed tracks of {len(clips)} annotated clips and {len(approaches)} simulated "
        f"approaches, {len(np.unique(judged.clip))} of which have tracks. A person who knows the ground truth changes "
        "a track that lies on no sign, has a wrong label, shares its sign with another track, or has boxes off its "
        "sign (IoU below 0.5 in at least 2 frames and a tenth of them). Four cameras film each clip, one of them each "
        "approach: as it is, with a fifth of the light, at half the size and compressed strongly, at a third of the "
        f"frames. Runs: {', '.join(RUNS)}. The fit that rates a track has not seen its clip, nor other "
        "clips of the same place.",
        figures={
            "tracks": len(judged.changed),
            "changed": int(judged.changed.sum()),
            "why": dict(Counter(why for why in judged.why if why)),
            "weights": {"constant": constant, **dict(zip(NAMES, whole.coef_[0].tolist(), strict=True))},
            "ways": {way: _scores(chances[way], judged.changed) for way in WAYS},
            "bins": {way: _bins(chances[way], judged.changed) for way in WAYS},
            "runs": {name: _of_run(chances["fitted"], judged, name) for name in RUNS},
        },
        settings={"weights in force": dict(WEIGHTS), "runs": list(RUNS), "cameras": list(cameras)},
    )


def _scores(chance: NDArray[np.float64], changed: NDArray[np.bool_]) -> dict[str, float]:
    safe = np.clip(chance, 0.001, 0.999)
    return {
        "brier": float(brier_score_loss(changed, safe)),
        "log_loss": float(log_loss(changed, safe)),
        "auroc": float(roc_auc_score(changed, chance)),
    }


def _bins(chance: NDArray[np.float64], changed: NDArray[np.bool_]) -> list[dict[str, float]]:
    found = []
    for low, high in pairwise(EDGES):
        here = (chance >= low) & ((chance < high) | (high == EDGES[-1]))
        if here.any():
            share = float(changed[here].mean())
            found.append(
                {"low": low, "high": high, "n": int(here.sum()), "said": float(chance[here].mean()), "changed": share}
            )
    return found


def _of_run(chance: NDArray[np.float64], judged: JudgedTracks, name: str) -> dict[str, float | int | None]:
    own = judged.run == name
    changed = judged.changed[own]
    both = changed.any() and not changed.all()
    return {
        "n": int(own.sum()),
        "changed": int(changed.sum()),
        "said": float(chance[own].sum()),
        "auroc": float(roc_auc_score(changed, chance[own])) if both else None,
    }


def _report(result: Result) -> str:
    f = result.figures
    rows = [["", "Brier", "log loss", "AUROC"]]
    rows += [[way, *(f"{f['ways'][way][key]:.3f}" for key in ("brier", "log_loss", "auroc"))] for way in WAYS]
    calibration = [["uncertainty", "tracks", "mean uncertainty", "changed"]]
    calibration += [
        [f"{b['low']:.0%} to {b['high']:.0%}", str(b["n"]), f"{b['said']:.1%}", f"{b['changed']:.1%}"]
        for b in f["bins"]["fitted"]
    ]
    runs = [["run", "tracks", "changed", "expected by the fit", "AUROC in it"]]
    runs += [
        [name, str(r["n"]), str(r["changed"]), f"{r['said']:.1f}", "" if r["auroc"] is None else f"{r['auroc']:.3f}"]
        for name, r in f["runs"].items()
    ]
    why = ", ".join(f"{count} {name}" for name, count in f["why"].items())
    weights = ", ".join(f"{name} {value:.2f}" for name, value in f["weights"].items())
    return "\n".join((
        f"{f['changed']} of {f['tracks']} tracks are changed ({why}). *Fitted* is a logistic regression that has not "
        "seen the clip of the track; *former* is the earlier sort key of the queue, without its term for verdicts near "
        "tau.\n",
        table(rows), "Calibration of the fitted uncertainty:\n", table(calibration),
        "The presets `default` and `lenient` make few mistakes here, so the fit learns the terms mostly from `paper`. "
        "The term *windows* keeps the chances apart: it is 1 for every track of a run that measures rejected "
        "predictions at relocalised windows, as `paper` does.\n", table(runs),
        f"Weights of a fit on all tracks: {weights}. Weights in use: "
        + ", ".join(f"{name} {value:.2f}" for name, value in result.settings["weights in force"].items())
        + ". Verdicts near tau, the detector's best score and disagreement with another run got a weight of 0 or of "
        "the wrong sign, so the fit leaves them out.\n",
    ))  # fmt: skip


def _plot(result: Result, path: Path) -> None:
    with saved_figure(path) as axes:
        axes.plot([0, 1], [0, 1], color="#999999", linewidth=1)
        for way, style in zip(WAYS, ("o-", "s:"), strict=True):
            bins: list[JsonMapping] = result.figures["bins"][way]
            axes.plot([b["said"] for b in bins], [b["changed"] for b in bins], style, label=way)
        axes.set(xlabel="uncertainty of the track", ylabel="share that is changed", xlim=(0, 1), ylim=(0, 1.02))
        axes.legend()


EXPERIMENT = Experiment(
    "uncertainty",
    "The uncertainty of the queue",
    "Is the uncertainty of a track the probability that a person changes it, and does it rank such tracks first?",
    _run,
    _report,
    _plot,
)
