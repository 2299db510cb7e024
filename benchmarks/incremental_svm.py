"""CPU time of one add and one removal of ``IncrementalSVC`` at n = 300 samples of d = 324 features.

Run: ``python benchmarks/incremental_svm.py``
"""

from __future__ import annotations

import time

import numpy as np

from tsr_engine import IncrementalSVC

N, D, REPEATS = 300, 324, 100


def main() -> None:
    """Print mean and maximum in ms for overlapping clouds and for unit-length descriptors, linear and RBF."""
    rng = np.random.default_rng(0)
    cloud = rng.normal(size=(N + REPEATS, D))
    y = np.where(cloud[:, 0] + 0.5 * rng.normal(size=N + REPEATS) > 0, 1, -1)
    unit = np.abs(cloud) + 0.3 * np.outer(y, np.linspace(0, 1, D))
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    for name, X in (("clouds", cloud), ("unit length", unit)):
        for kernel in ("linear", "rbf"):
            model = IncrementalSVC(C=1.0, kernel=kernel).partial_fit(X[:N], y[:N])
            adds, removals, worst = [], [], 0.0
            for k in range(N, N + REPEATS):
                start = time.process_time_ns()
                model.partial_fit(X[k : k + 1], y[k : k + 1])
                middle = time.process_time_ns()
                model.unlearn(0)
                adds.append((middle - start) / 1e6)
                removals.append((time.process_time_ns() - middle) / 1e6)
                worst = max(worst, model.kkt_residual())
            print(
                f"{name:12s} {kernel:7s} add {np.mean(adds):.2f} ms mean, {max(adds):.2f} max; "
                f"removal {np.mean(removals):.2f} mean, {max(removals):.2f} max; "
                f"margin vectors {len(model.margin_)}, KKT {worst:.1e}"
            )


if __name__ == "__main__":
    main()
