"""Made-up evidence with every kind of data: two tracks, and frames without any."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tsr_engine.evidence import EvidenceWriter, RunHeader, TableEntry, VideoIdentity
from tsr_engine.io.video import open_video
from tsr_engine.io.video_probe import video_sha256
from tsr_engine.records import (
    Detections,
    Event,
    FrameEvidence,
    GateVerdict,
    Prediction,
    Recognition,
    Relocalisation,
    TrackFrame,
)

CLASSES = 43


def track(frame: int, number: int) -> TrackFrame | None:
    """Track 7 lives in frames 2 to 20 except 10 to 12; track 9 lives from frame 5 and dies in 15."""
    alive = 2 <= frame <= 20 and not 10 <= frame <= 12 if number == 7 else 5 <= frame <= 15
    if not alive:
        return None
    rng = np.random.default_rng([frame, number])
    box = np.array([10.0 * number, 20.0, 10.0 * number + 12.5, 33.25]) + frame / 3
    votes = rng.random(CLASSES) * (np.arange(CLASSES) < 3)
    born = frame in (2, 5)
    missed = frame % 3 == 0 and not born
    gate = GateVerdict(0.4, 2.5, 12.0, 0.5 + frame, float(10.0 ** (frame % 4 - 1)), confident=frame % 4 < 2)
    found = Relocalisation(box - 9, box + 1, 0.75, 0.68, box - 4, -0.5, 441)
    return TrackFrame(
        track_id=number,
        state="dead" if number == 9 and frame == 15 else "tentative" if born else "confirmed",
        source="relocalised" if missed else "detected",
        box=box,
        score=float(rng.normal()),
        prediction=None if born else Prediction(box - 0.5, np.diag([4.0, 9.0, 1.0, 1.0])),
        detection=None if missed else 0,
        gate=None if born else gate,
        relocalisation=found if missed else None,
        samples=(),
        recognition=Recognition(
            rng.random(CLASSES).astype(np.float32), 12.0, 0.25, votes, int(np.argmax(votes)), 0.6, 1
        ),
    )


def evidence_of(frame: int, size: tuple[int, int]) -> FrameEvidence:
    tracks = tuple(t for t in (track(frame, 9), track(frame, 7)) if t is not None)
    boxes = np.array([t.box + 0.125 for t in tracks if t.detection is not None]).reshape(-1, 4)
    n = len(boxes)
    rng = np.random.default_rng(frame)
    return FrameEvidence(
        ordinal=frame,
        seconds=frame / 25,
        width=size[0],
        height=size[1],
        detections=Detections(boxes, rng.normal(size=n), rng.random(n), rng.normal(size=n)),
        shift=(0.0, 0.0),
        tracks=tracks,
        events=(Event("rejected", 7, "Track 7 was rejected.", {}),) if frame == 8 else (),
        regions=(),
        timings={},
    )


def write_run(folder: Path, frames: int = 30, video: Path | None = None) -> Path:
    """A complete run; with a video, it has the video's frames."""
    identity, entries, size = VideoIdentity("drive.mp4", "ab" * 32, 1), [TableEntry()] * frames, (320, 240)
    if video is not None:
        with open_video(video) as file:
            table, size = file.confirm(), (file.width, file.height)
        identity = VideoIdentity(video.name, video_sha256(video), video.stat().st_size)
        rows = zip(table.pts.tolist(), table.key.tolist(), table.corrupt.tolist(), strict=True)
        entries = [TableEntry(*row) for row in rows]
    header = RunHeader(video=identity, parameters={"gate": {"tau": 15.0}}, models={"detector": "cd" * 32})
    with EvidenceWriter.create(folder, header) as writer:
        for k, entry in enumerate(entries):
            writer.append(evidence_of(k, size), entry)
    return folder
