"""Measures time and memory of the export of a long drive, and of reading it back, for every format without pictures.

The drive has 132,400 frames and 5,000 tracks of 25 to 50 boxes; the budget is 20 s and 500 MB per format. The
experiment ``exports`` runs ``python benchmarks/timing/exports.py FORMAT`` for each.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np

from benchmarks.timing.processes import memory
from tsr_engine.errors import TsrError
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Track
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.files import DEFAULT, shipped_set

FRAMES = 132_400
TRACKS = 5_000
MOST_SECONDS, MOST_MB = 20.0, 500
WITHOUT_PICTURES = tuple(known.name for known in FORMATS.values() if not known.needs_pictures)
"""Names of the formats that do not need pictures."""


def drive() -> Dataset:
    """A synthetic drive: approaching signs with the jitter of a tracker, each visible for one to two seconds.

    Its tracks are made once in advance, since an export reads them up to four times.
    """
    starts = np.sort(np.random.default_rng(1).integers(0, FRAMES - 60, TRACKS))

    def made() -> Iterator[Track]:
        for number, start in enumerate(starts.tolist()):
            rng = np.random.default_rng(number)
            count = int(rng.integers(25, 51))
            along = np.linspace(0.0, 1.0, count)
            side = 16.0 / (1.15 - along)
            centre = np.stack([640 + rng.uniform(100, 450) * along**2, 360 - 150 * along**2], axis=1)
            boxes = np.concatenate([centre - side[:, None] / 2, centre + side[:, None] / 2], axis=1)
            yield Track(
                uid=f"m{number}",
                label=number % len(shipped_set(DEFAULT)),
                frames=np.arange(start, start + count, dtype=np.int64),
                boxes=boxes + rng.normal(0.0, 0.25, boxes.shape),
                key=np.zeros(count, dtype=np.bool_),
                occluded=np.zeros(count, dtype=np.bool_),
                score=rng.random(count),
                state="accepted",
            )

    tracks = list(made())
    times = np.arange(FRAMES) / 30.0
    video = DatasetVideo(
        "drive.mp4", "0" * 64, 1280, 720, FRAMES, Fraction(30), times, True, lambda: iter(tracks), stop=FRAMES
    )
    return Dataset(shipped_set(DEFAULT), (video,))


def measure(name: str) -> dict[str, object]:
    """Export a ZIP file in this process and read it back: seconds, peak MB, size, and numbers of boxes."""
    data = drive()
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "export.zip"
        begin, worked = time.perf_counter(), time.process_time()
        manifest = export_dataset(data, FORMATS[name], out, zipped=True)
        seconds = time.perf_counter() - begin
        found: dict[str, object] = {
            "format": name,
            "seconds": round(seconds, 2),
            "cpu_seconds": round(time.process_time() - worked, 2),
            "load": round(os.getloadavg()[0], 1),
            "peak_mb": round(memory()["peak_mb"]),
            "files": len(manifest.files),
            "mb": round(sum(entry["size"] for entry in manifest.files) / 1e6, 1),
            "boxes": manifest.counts["boxes"],
        }
        if FORMATS[name].read is not None:
            begin, worked = time.perf_counter(), time.process_time()
            back = read_dataset(out, ImportTarget(data.videos[0], shipped_set(DEFAULT)))
            found["read_seconds"] = round(time.perf_counter() - begin, 2)
            found["read_cpu_seconds"] = round(time.process_time() - worked, 2)
            found["read_boxes"] = sum(len(track.frames) for track in back.videos[0].tracks())
            found["read_peak_mb"] = round(memory()["peak_mb"])
    return found


def measure_in_new_process(name: str) -> JsonObject:
    """Measure one format in a separate process, so that the peak memory belongs to it alone.

    Raises:
        TsrError: the process ended without a result.
    """
    command = [sys.executable, __file__, name]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)  # noqa: S603
    if done.returncode:
        raise TsrError(f"{name}: {done.stderr.strip()[-400:]}")
    found: JsonObject = json.loads(done.stdout)
    return found


def main() -> None:
    """Measure one format in this process."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("format", choices=WITHOUT_PICTURES)
    print(json.dumps(measure(parser.parse_args().format)))


if __name__ == "__main__":
    main()
