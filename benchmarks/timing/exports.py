"""Measures time and memory of the export of a long drive, and of reading it back, for every format without pictures.

::

    python benchmarks/timing/exports.py                    # all formats, each in a fresh process
    python benchmarks/timing/exports.py cvat-video --read

The drive has 132,400 frames and 5,000 tracks of 25 to 50 boxes; the budget is 20 s and 500 MB per format. The
experiment ``exports`` reports the figures.
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

from benchmarks.timing.memory import memory
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


def measure(name: str, *, zipped: bool, read: bool) -> dict[str, object]:
    """Measure one format in this process: seconds, peak MB, size, and the tracks read back."""
    data = drive()
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / ("export.zip" if zipped else "export")
        begin, worked = time.perf_counter(), time.process_time()
        try:
            manifest = export_dataset(data, FORMATS[name], out, zipped=zipped)
        except TsrError as error:
            return {"format": name, "refused": str(error)}
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
        if read and FORMATS[name].read is not None:
            begin, worked = time.perf_counter(), time.process_time()
            back = read_dataset(out, ImportTarget(data.videos[0], shipped_set(DEFAULT)))
            found["read_seconds"] = round(time.perf_counter() - begin, 2)
            found["read_cpu_seconds"] = round(time.process_time() - worked, 2)
            found["read_boxes"] = sum(len(track.frames) for track in back.videos[0].tracks())
            found["read_peak_mb"] = round(memory()["peak_mb"])
    return found


def measured(name: str, *, zipped: bool = True, read: bool = False) -> JsonObject:
    """Measure one format in a separate process, so that the peak memory belongs to it alone.

    Raises:
        TsrError: the process ended without a result.
    """
    flags = [flag for flag, on in (("--folder", not zipped), ("--read", read)) if on]
    command = [sys.executable, __file__, name, "--here", *flags]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)  # noqa: S603
    if done.returncode:
        raise TsrError(f"{name}: {done.stderr.strip()[-400:]}")
    found: JsonObject = json.loads(done.stdout)
    return found


def main() -> None:
    """Measure the named formats, or all, each in a separate process."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("formats", nargs="*", help="names of formats; unset: all")
    parser.add_argument("--folder", action="store_true", help="write a folder instead of a ZIP file")
    parser.add_argument("--read", action="store_true", help="also read the export back")
    parser.add_argument("--here", action="store_true", help="measure in this process")
    args = parser.parse_args()
    one = measure if args.here else measured
    for name in args.formats or WITHOUT_PICTURES:
        print(json.dumps(one(name, zipped=not args.folder, read=args.read)), flush=True)


if __name__ == "__main__":
    main()
