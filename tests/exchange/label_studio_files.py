"""A small export of Label Studio: one region in a video of 100 frames."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tests.exchange.small_datasets import make_dataset, target_of, tracks_of
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS

_SIZE = {"y": 20, "width": 5, "height": 10, "rotation": 0}
_REGION = {
    "id": "t7",
    "type": "videorectangle",
    "from_name": "box",
    "to_name": "video",
    "origin": "prediction",
    "value": {
        "framesCount": 100,
        "duration": 4.0,
        "labels": ["stop"],
        "sequence": [
            {"frame": 11, "time": 0.44, "x": 10, **_SIZE, "enabled": True},
            {"frame": 41, "time": 1.64, "x": 40, **_SIZE, "enabled": False},
        ],
    },
    "meta": {"text": ["uid=7f3a"]},
}
SAMPLE: list[dict[str, Any]] = [
    {
        "data": {"video": "https://host/drive.mp4", "fps": 25.0},
        "predictions": [{"model_version": "engine-abc", "score": 0.9, "result": [_REGION]}],
    }
]
REGION = "0/predictions/0/result/0"


def read_tasks(folder: Path, content: Any, data: Dataset | None = None) -> Dataset:
    """Read tasks onto the video of the small data set, or of another one."""
    path = folder / "tasks.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return read_dataset(path, target_of(make_dataset() if data is None else data), FORMATS["label-studio"])


def first_frame(found: Dataset) -> int:
    """First frame of the only track."""
    (track,) = tracks_of(found).values()
    return int(track.frames[0])
