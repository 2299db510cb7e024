"""A long run in a separate process, which regularly notes its time and memory.

    python -m benchmarks.timing.long_run real VIDEO FOLDER --stop 4500 --seconds 500
    python -m benchmarks.timing.long_run repeated VIDEO FOLDER --stop 132400 --seconds 500

``real`` is `tsr track` on the file. ``repeated`` decodes, detects and measures the camera shift once for each frame of
a short clip, and repeats these results for the whole drive. Tracking, gate, online detector, recognition, result rows
and evidence do all their work for every frame. In most repetitions, detections are left out, since signs are rare on
real drives.

Both store evidence in FOLDER and notes in FOLDER/notes.jsonl. They stop when the time is over; the same command
continues.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, TextIO

import cv2

from benchmarks.systems.detection_records import detections_from_record, detections_to_record
from benchmarks.timing.looped_video import RATE
from benchmarks.timing.processes import memory
from tsr_engine.evidence import EvidenceReader, EvidenceWriter, FramePixels, RunHeader, RunState, VideoIdentity
from tsr_engine.evidence.schema import RUN_FILE
from tsr_engine.io.video import open_video, video_sha256
from tsr_engine.json_shapes import JsonObject
from tsr_engine.params import Params
from tsr_engine.pipeline import (
    Components,
    FrameInput,
    ResultStream,
    TrackingCore,
    load_components,
    one_blas_thread,
    rebuild_core,
    replay_regions,
)
from tsr_engine.records import Detections, Picture
from tsr_engine.runs.track_video import Progress, RunRequest, track_video
from tsr_engine.tracking.camera_shift import CameraShift

NOTES: Final = "notes.jsonl"
STEP: Final = 100
"""Number of frames between two notes; reported lengths are multiples of it."""
DETECTION_PERIOD: Final = 8
"""Period of repetitions; only the first of each period has detections."""


@dataclass(frozen=True, slots=True)
class DetectedFrame:
    """A frame of the short clip with the results of all steps before tracking."""

    picture: Picture
    detections: Detections
    shift: tuple[float, float]


def detect_once(video: Path, components: Components, params: Params, kept: Path | None = None) -> list[DetectedFrame]:
    """Decode a short clip, detect in every frame, and measure its camera shift.

    Args:
        video: the clip.
        components: trained parts; only the detector is used.
        params: parameters of the run.
        kept: file for the results, so that the next process only decodes; unset: none.
    """
    key = {"video": video_sha256(video), "models": dict(components.models), "params": params.model_dump(mode="json")}
    answers = _read_answers(kept, key) if kept is not None else []
    tracking = params.tracking
    shift = CameraShift(tracking.shift_scale, (tracking.foe_x, tracking.foe_y))
    clip: list[DetectedFrame] = []
    with open_video(video) as opened:
        for frame in opened.frames(0, None):
            if len(answers) > len(clip):
                *record, (x, y) = answers[len(clip)]
                clip.append(DetectedFrame(frame.picture, detections_from_record(record), (x, y)))
            else:
                step = shift.step(frame.picture)
                clip.append(DetectedFrame(frame.picture, components.detector.detect(frame.picture), step))
    if kept is not None and not answers:
        rows = [[*detections_to_record(seen.detections), list(seen.shift)] for seen in clip]
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_text(json.dumps({"key": key, "answers": rows}), encoding="utf-8")
    return clip


def _read_answers(path: Path, key: JsonObject) -> list[list[list[float]]]:
    """Results of an earlier process for the same key; empty if there are none."""
    if not path.is_file():
        return []
    reported = json.loads(path.read_text(encoding="utf-8"))
    return list(reported["answers"]) if reported["key"] == json.loads(json.dumps(key)) else []


def repeated(
    clip: list[DetectedFrame],
    components: Components,
    params: Params,
    identity: VideoIdentity,
    folder: Path,
    stop: int,
    note: Callable[[int], bool],
) -> int:
    """Do all steps of a run after detection over a repeated clip; continues the run in the folder.

    Args:
        clip: the frames of one repetition.
        components: trained parts; the detector is not used.
        params: parameters of the run.
        identity: identity of the clip.
        folder: folder of the evidence.
        stop: frame after the last.
        note: called after each frame with the number of frames done; false ends the run.

    Returns:
        Number of frames done, including earlier calls.
    """
    height, width = clip[0].picture.shape[:2]
    table: JsonObject = {"time_base": f"1/{RATE}", "frames": stop, "width": width, "height": height}
    table |= {"rotation": 0, "interval": 1 / RATE, "learned_lambda": components.learned_lambda}
    header = RunHeader(identity, params.model_dump(mode="json"), dict(components.models), table)
    begun = (folder / RUN_FILE).is_file()
    writer = EvidenceWriter.resume(folder, header) if begun else EvidenceWriter.create(folder, header)
    first = 0 if writer.last_frame is None else writer.last_frame + 1
    state: RunState = "interrupted"
    try:
        core = TrackingCore(params, components.parts, width, height, interval=1 / RATE)
        if first:
            with EvidenceReader(folder) as reader:
                core = rebuild_core(reader, params, components.parts, first - 1)
        rows = ResultStream()
        done = first
        with one_blas_thread():
            for ordinal in range(first, stop):
                seen = clip[ordinal % len(clip)]
                shown = (ordinal // len(clip)) % DETECTION_PERIOD == 0
                pixels = FramePixels(seen.picture)
                detections = seen.detections if shown else Detections.empty()
                given = FrameInput(ordinal, ordinal / RATE, detections, seen.shift, pixels)
                evidence = core.step(given)
                deque(rows.add(evidence), maxlen=0)
                writer.append(replace(evidence, regions=replay_regions(evidence, pixels, params)))
                done = ordinal + 1
                if not note(done):
                    break
        if done == stop:
            state = "complete"
    finally:
        writer.close(state, "" if state == "complete" else "The time was over.")
    return done


def note_writer(lines: TextIO, seconds: float) -> Callable[[int], bool]:
    """A callback that writes a note every `STEP` frames, and returns whether there is time left."""
    began, cpu = time.monotonic(), time.process_time()

    def note(done: int) -> bool:
        passed = time.monotonic() - began
        if done % STEP == 0:
            now = {"frames": done, "wall": passed, "cpu": time.process_time() - cpu}
            lines.write(json.dumps({k: round(v, 3) for k, v in (now | memory()).items()}) + "\n")
            lines.flush()
        return passed < seconds

    return note


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=("real", "repeated"))
    parser.add_argument("video", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--stop", type=int, required=True)
    parser.add_argument("--seconds", type=float, default=1e9, help="stop after this time")
    args = parser.parse_args()
    cv2.setNumThreads(1)
    params = Params()
    components = load_components(params)
    clip = detect_once(args.video, components, params, args.folder / "seen.json") if args.kind == "repeated" else []
    args.folder.mkdir(parents=True, exist_ok=True)
    with (args.folder / NOTES).open("a", encoding="utf-8") as lines:
        held = sum(seen.picture.nbytes for seen in clip) / 1e6
        lines.write(json.dumps({"held_mb": round(held, 3), "at": time.time()}) + "\n")
        note = note_writer(lines, args.seconds)
        if args.kind == "repeated":
            identity = VideoIdentity(args.video.name, video_sha256(args.video), args.video.stat().st_size)
            repeated(clip, components, params, identity, args.folder, args.stop, note)
            return
        enough = False

        def after(progress: Progress) -> None:
            nonlocal enough
            enough = not note(progress.done)

        request = RunRequest(args.video, params, evidence=args.folder, stop=args.stop)
        track_video(request, components, progress=after, stop=lambda: enough)


if __name__ == "__main__":
    main()
