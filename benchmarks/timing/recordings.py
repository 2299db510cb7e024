"""Measures size and time of a recording of 300 frames of 1280x720; the limits are 5 MB and 2 s.

Two drives are made and tracked: one whose packets fit and are copied, and one whose pictures must be encoded again.
Each is recorded several times in a new process, as ``tsr record`` does (the first recording also loads the SDK), and
once by the command itself, whose time includes the start of Python.

::

    python benchmarks/timing/recordings.py                # the shipped drive, enlarged
    python benchmarks/timing/recordings.py --clips DIR    # the clips of that size with the fewest and the most bytes
    python benchmarks/timing/recordings.py --work DIR     # keep drives and runs in DIR, and use existing ones

The experiment ``recordings`` reports the figures.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack
from fractions import Fraction
from itertools import islice
from pathlib import Path

import av
import cv2

from benchmarks.timing.looped_video import repeat_clip
from sample_videos import SHIPPED
from tsr_engine.errors import TsrError
from tsr_engine.io.video import open_video
from tsr_engine.io.video_writer import VideoWriter
from tsr_engine.json_shapes import JsonObject
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components
from tsr_engine.recording import RecordingRequest, write_recording
from tsr_engine.recording.transcode import size_limit
from tsr_engine.records import Picture
from tsr_engine.runs.track_video import RunRequest, track_video

FRAMES, WIDTH, HEIGHT = 300, 1280, 720
KINDS = ("copied", "encoded")
MOST_MB, MOST_SECONDS = 5.0, 2.0
_CRF = {"copied": (26, 32, 38, 44), "encoded": (20, 14, 8, 2)}
"""Qualities to try, in order, until the packets fit (``copied``) or do not fit (``encoded``)."""


def main() -> None:
    """Print one JSON line for each of the two drives; returns 1 if a recording exceeds a limit."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--clips", type=Path, help=f"folder of clips; only those of {WIDTH}x{HEIGHT} px are used")
    parser.add_argument("--work", type=Path, help="folder that keeps drives and runs")
    parser.add_argument("--times", type=int, default=4, help="recordings in one process")
    parser.add_argument("--here", nargs=2, type=Path, metavar=("RUN", "VIDEO"), help="record one run in this process")
    args = parser.parse_args()
    if args.here:
        print(json.dumps(record(args.here[0], args.here[1], args.times)))
        return
    met = True
    with ExitStack() as stack:
        work = args.work or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        work.mkdir(parents=True, exist_ok=True)
        for kind in KINDS:
            found = measure(kind, work, args.clips, args.times)
            met &= found["megabytes"] <= MOST_MB and max(found["seconds"]) <= MOST_SECONDS
            print(json.dumps(found), flush=True)
    sys.exit(0 if met else 1)


def measure(kind: str, work: Path, clips: Path | None, times: int) -> JsonObject:
    """Make and track a drive if necessary, and record it.

    Args:
        kind: ``copied`` or ``encoded``: the treatment of its packets.
        work: folder for drive and run.
        clips: folder of clips; None: the shipped drive.
        times: number of recordings in one process.

    Returns:
        ``megabytes``; ``seconds`` and ``cpu_seconds`` of each recording of one process, and of the whole command; and
        the machine's load before.
    """
    video, run = work / f"{kind}.mp4", work / f"{kind}-run"
    if not video.is_file():
        source = _drive(kind, video, clips)
        (work / f"{kind}.txt").write_text(source, encoding="utf-8")
    if not (run / "evidence.sqlite").is_file():
        params = Params()
        track_video(RunRequest(video, params, evidence=run, stop=FRAMES, restart=True), load_components(params))
    load = os.getloadavg()[0]
    here = _process([sys.executable, __file__, "--here", str(run), str(video), "--times", str(times)])
    out = work / f"{kind}.rrd"
    command = [sys.executable, "-c", "from app.cli.main import run; run()", "record", str(run)]
    whole = _process([*command, "--video", str(video), "--out", str(out), "--frames", f"0:{FRAMES}", "--json"])
    return {
        "drive": kind,
        "source": (work / f"{kind}.txt").read_text(encoding="utf-8"),
        **json.loads(here["output"]),
        "command_seconds": whole["seconds"],
        "command_cpu_seconds": whole["cpu_seconds"],
        "cores": len(os.sched_getaffinity(0)),
        "load": round(load, 1),
    }


def record(run: Path, video: Path, times: int) -> JsonObject:
    """Record a run in this process, several times."""
    found: JsonObject = {"seconds": [], "cpu_seconds": []}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(times):
            began, worked = time.perf_counter(), time.process_time()
            report = write_recording(
                RecordingRequest(run, Path(folder) / "drive.rrd", first=0, stop=FRAMES, video=video)
            )
            found["seconds"].append(round(time.perf_counter() - began, 2))
            found["cpu_seconds"].append(round(time.process_time() - worked, 2))
    found["megabytes"] = round(report.size / 1e6, 2)
    found["picture_megabytes"] = round(report.picture_size / 1e6, 2)
    found["picture"], found["boxes"] = report.picture, sum(report.boxes.values())
    return found


def _process(command: list[str]) -> JsonObject:
    """Run a process; returns its output and times."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)  # noqa: S603
    seconds, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise TsrError(f"{' '.join(command[:4])} ended with {done.returncode}: {done.stderr.strip()[-400:]}")
    worked = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {"output": done.stdout, "seconds": round(seconds, 2), "cpu_seconds": round(worked, 2)}


def _drive(kind: str, out: Path, clips: Path | None) -> str:
    """Write a video of at least ``FRAMES`` frames; returns the name of its source."""
    if clips is not None:
        clip = clip_of_kind(kind, clips)
        repeat_clip(clip, out, FRAMES)
        return f"{clip.name}, joined to itself, packets as they were"
    source = SHIPPED[0].video
    for crf in _CRF[kind]:
        with VideoWriter(out, WIDTH, HEIGHT, Fraction(30), crf=crf, key_distance=FRAMES // 10) as writer:
            for picture in islice(_pictures(source), FRAMES):
                writer.write(picture)
        if (out.stat().st_size <= size_limit(FRAMES, WIDTH, HEIGHT)) == (kind == "copied"):
            return f"{source.name}, enlarged, at crf {crf}"
    raise TsrError(f"No quality of {_CRF[kind]} makes a drive that is {kind}.")


def _pictures(source: Path) -> Iterator[Picture]:
    while True:
        with open_video(source) as video:
            for frame in video.frames():
                yield cv2.resize(frame.picture, (WIDTH, HEIGHT), interpolation=cv2.INTER_CUBIC)  # type: ignore[misc]


def clip_of_kind(kind: str, folder: Path) -> Path:
    """The clip with the fewest or the most bytes per frame."""
    rates = {}
    for path in sorted(folder.glob("*.mp4")):
        with av.open(path) as container:
            stream = container.streams.video[0]
            if (stream.width, stream.height) == (WIDTH, HEIGHT) and stream.frames:
                rates[path] = path.stat().st_size / stream.frames
    if not rates:
        raise TsrError(f"{folder} has no clip of {WIDTH}x{HEIGHT}. Name another folder with --clips.")
    return (min if kind == "copied" else max)(rates, key=lambda path: rates[path])


if __name__ == "__main__":
    main()
