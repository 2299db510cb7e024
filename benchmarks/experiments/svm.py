"""Compares one exact incremental step of the SVM with a new training."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from sklearn.svm import SVC
from threadpoolctl import threadpool_limits

from benchmarks.experiment import Data, Experiment, Result
from benchmarks.reporting.markdown import table
from tsr_engine import IncrementalSVC

SIZES = (50, 100, 200, 300)
FEATURES = 324
STEPS = 40


def _ms(work: Callable[[int], object]) -> float:
    times = []
    for step in range(STEPS):
        began = time.thread_time()
        work(step)
        times.append(time.thread_time() - began)
    return float(np.mean(times)) * 1e3


def _row(size: int, seed: int) -> dict[str, float]:
    rng = np.random.default_rng(seed)
    X = np.abs(rng.normal(size=(size + STEPS, FEATURES)))
    y = np.where(rng.normal(size=size + STEPS) > 0, 1, -1)
    X += 0.3 * np.outer(y, np.linspace(0, 1, FEATURES))
    X /= np.linalg.norm(X, axis=1, keepdims=True)
    model = IncrementalSVC(C=1.0, kernel="linear").partial_fit(X[:size], y[:size])
    add = _ms(lambda k: model.partial_fit(X[size + k : size + k + 1], y[size + k : size + k + 1]))
    gap = model.kkt_residual()
    remove = _ms(lambda _: model.unlearn(0))
    anew = _ms(lambda k: SVC(C=1.0, kernel="linear", tol=1e-8).fit(X[: size + k + 1], y[: size + k + 1]))
    return {"n": size, "add_ms": add, "remove_ms": remove, "anew_ms": anew, "kkt": float(gap)}


def _run(data: Data) -> Result:
    with threadpool_limits(limits=1):
        rows = [_row(size, data.seed) for size in SIZES]
    return Result(
        data=f"Random vectors of unit length with {FEATURES} values in two overlapping classes (no pictures), linear "
        f"kernel, C = 1; CPU time of one thread, mean over {STEPS} steps.",
        figures={"rows": rows},
        settings={"seed": data.seed},
    )


def _report(result: Result) -> str:
    rows = [["samples", "add, ms", "remove, ms", "libsvm from scratch, ms", "KKT residual after the adds"]]
    rows += [
        [str(r["n"]), f"{r['add_ms']:.2f}", f"{r['remove_ms']:.2f}", f"{r['anew_ms']:.1f}", f"{r['kkt']:.0e}"]
        for r in result.figures["rows"]
    ]
    return table(rows)


EXPERIMENT = Experiment(
    "svm",
    "The incremental SVM compared with a batch solver",
    "How long does the exact update for one sample take, compared with training from scratch?",
    _run,
    _report,
)
