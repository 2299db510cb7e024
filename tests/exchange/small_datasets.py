"""Small data sets for the tests of exports and imports."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Track
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions, ImportTarget
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS
from tsr_engine.io.video_writer import VideoWriter
from tsr_engine.labels.files import shipped_set
from tsr_engine.labels.model import Attribute, Label, LabelSet

GTSRB = shipped_set("gtsrb-43")
CLASS_NAMES = tuple(label.name for label in GTSRB)


def make_label_set(*names: str, attributes: Sequence[Attribute] = ()) -> LabelSet:
    """A set with labels of these names, numbered from 0, each with these attributes."""
    labels = tuple(
        Label(id=at, key=f"key {at}", name=name, attributes=tuple(attributes)) for at, name in enumerate(names)
    )
    return LabelSet(key="toys", name="toys", next_id=len(names), labels=labels)


def make_track(
    uid: str = "m1",
    frames: Sequence[int] = range(10, 40),
    *,
    label: int = 14,
    boxes: object = None,
    jitter: float = 0.2,
    **more: object,
) -> Track:
    """An approaching sign with the jitter of a tracker."""
    n = len(frames)
    if boxes is None:
        rng = np.random.default_rng(abs(hash(tuple(frames))) % 2**32)
        along = np.linspace(0.0, 1.0, n)
        side = 20 + 40 * along**2
        x, y = 100 + 200 * along**2, 150 - 50 * along
        boxes = np.stack([x, y, x + side, y + side], axis=1) + rng.normal(0, jitter, (n, 4))
    values: dict[str, object] = {
        "key": np.zeros(n, dtype=np.bool_),
        "occluded": np.zeros(n, dtype=np.bool_),
        "score": np.full(n, np.nan),
    }
    values.update(more)
    return Track(
        uid,
        label,
        np.array(frames, dtype=np.int64),
        np.array(boxes, dtype=np.float64).reshape(n, 4),
        **values,  # type: ignore[arg-type]
    )


def make_video(
    tracks: Sequence[Track] = (), *, name: str = "drive.mp4", sha: str = "a" * 64, **more: object
) -> DatasetVideo:
    """100 frames of 640x360 px at 25 frames a second."""
    frames = int(str(more.pop("frames", 100)))
    values: dict[str, object] = {
        "rate": Fraction(25),
        "times": np.arange(frames) / 25.0,
        "constant_rate": True,
        "stop": frames,
    }
    values.update(more)
    return DatasetVideo(
        name=name,
        sha256=sha,
        width=640,
        height=360,
        frames=frames,
        tracks=lambda: iter(tracks),
        **values,  # type: ignore[arg-type]
    )


def write_grey_video(path: Path, width: int = 64, height: int = 48, frames: int = 16) -> Path:
    """A video of even pictures, each brighter than the one before."""
    with VideoWriter(path, width, height, Fraction(25)) as writer:
        for k in range(frames):
            writer.write(np.full((height, width, 3), 160 * k // frames, dtype=np.uint8))
    return path


def make_dataset(*tracks: Track, **video: object) -> Dataset:
    """One video with these tracks; by default three, with a gap, occlusion, notes, scores and a state."""
    if not tracks:
        held = np.zeros(20, dtype=np.bool_)
        held[4:9] = True
        tracks = (
            make_track("m1", range(10, 40), state="accepted", notes=((12, "lamp? <b>&\n\ttwo lines"), (30, "ö"))),
            make_track("m2", [*range(20, 30), *range(33, 43)], label=1, occluded=held, score=np.linspace(0.1, 0.9, 20)),
            make_track("h3", range(80, 100), label=-1, source="human", state="needs_work"),
        )
    return Dataset(GTSRB, (make_video(tracks, **video),))


def target_of(dataset: Dataset, **more: object) -> ImportTarget:
    """An import onto the data set's own video."""
    return ImportTarget(dataset.videos[0], dataset.labels, **more)  # type: ignore[arg-type]


def round_trip(dataset: Dataset, format: str, folder: Path, **options: object) -> Dataset:
    """Export as a ZIP file and import it again."""
    out = folder / "export.zip"
    export_dataset(dataset, FORMATS[format], out, ExportOptions(**options), zipped=True)  # type: ignore[arg-type]
    return read_dataset(out, target_of(dataset))


def tracks_of(dataset: Dataset) -> dict[str, Track]:
    """Tracks of the first video by name."""
    return {track.uid: track for track in dataset.videos[0].tracks()}


def same_tracks(dataset: Dataset, back: Dataset, px: float) -> Iterator[tuple[Track, Track]]:
    """Yield each track with the one that an import gives, which has the same name, facts and boxes, up to ``px``."""
    again = tracks_of(back)
    assert list(again) == list(tracks_of(dataset))
    for uid, track in tracks_of(dataset).items():
        found = again[uid]
        assert found.frames.tolist() == track.frames.tolist()
        assert np.abs(found.boxes - track.boxes).max() <= px + 1e-9
        assert (found.label, found.state, found.source, found.notes) == (
            *(track.label, track.state, track.source, track.notes),
        )
        yield track, found


def with_value(sample: Any, path: str, value: Any) -> Any:
    """A copy of a file's content with another value at ``items/0/name``; ``...`` removes it."""
    content = copy.deepcopy(sample)
    at = content
    *parents, last = [int(part) if part.isdigit() else part for part in path.split("/")]
    for part in parents:
        at = at[part]
    if value is ...:
        del at[last]
    else:
        at[last] = value
    return content
