"""Made-up evidence that uses every field of every record."""

from __future__ import annotations

from typing import Any

import numpy as np

from tsr_engine.evidence import RunHeader, VideoIdentity
from tsr_engine.records import (
    Detections,
    Event,
    FrameEvidence,
    GateVerdict,
    Prediction,
    Recognition,
    Region,
    Relocalisation,
    Sample,
    TrackFrame,
)


def make_header(**changes: Any) -> RunHeader:
    fields: dict[str, Any] = {
        "video": VideoIdentity("drive.mp4", "ab" * 32, 12345),
        "parameters": {"gate": {"tau": 15.0}, "online": {"search_scales": (1.0, 1.1)}},
        "models": {"detector": "cd" * 32},
        "frame_table": {"time_base": "1/30", "announced": 90},
    }
    return RunHeader(**(fields | changes))


def make_track(rng: np.random.Generator, track_id: int, **changes: Any) -> TrackFrame:
    votes = rng.random(43)
    fields: dict[str, Any] = {
        "track_id": track_id,
        "state": "confirmed",
        "source": "relocalised",
        "box": rng.random(4) * 100,
        "score": float(rng.normal()),
        "prediction": Prediction(rng.random(4) * 100, rng.normal(size=(4, 4))),
        "detection": 0,
        "gate": GateVerdict(*rng.random(5).tolist(), confident=bool(rng.integers(2))),
        "relocalisation": Relocalisation(
            rng.random(4), rng.random(4), -0.0, 0.5, rng.random(4), float(rng.normal()), 1681
        ),
        "samples": (Sample("learned", -1, "prediction", 7), Sample("unlearned", 1, "offline", -1)),
        "recognition": Recognition(rng.random(43).astype(np.float32), 31.5, 0.75, votes, 12, 0.9, 3),
    }
    return TrackFrame(**(fields | changes))


def make_frame(ordinal: int, tracks: int | tuple[TrackFrame, ...] = 2, **changes: Any) -> FrameEvidence:
    rng = np.random.default_rng(ordinal)
    n = int(rng.integers(0, 4))
    fields: dict[str, Any] = {
        "ordinal": ordinal,
        "seconds": ordinal / 30,
        "width": 720,
        "height": 576,
        "detections": Detections(rng.random((n, 4)) * 500, rng.normal(size=n), rng.random(n), rng.normal(size=n)),
        "shift": (float(rng.normal()), -0.0),
        "tracks": tracks if isinstance(tracks, tuple) else tuple(make_track(rng, i + 1) for i in range(tracks)),
        "events": (Event("relocalised", 1, "Track 1 was found again.", {"L": 0.1 + 0.2, "n": 3, "why": "glare"}),),
        "regions": (Region(5, 9, rng.integers(0, 256, (8, 11, 3), dtype=np.uint8)),),
        "timings": {"detect": float(rng.random()), "classify": float(rng.random())},
    }
    return FrameEvidence(**(fields | changes))
