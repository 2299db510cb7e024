"""Passes a data set of one video between two of our processes, as arrays and JSON without executable content."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.attributes import parse_attributes
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Skipped, Track
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.load import check_dataset
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.files import dump_set, parse_set

_REQUIRED: Final = ("frames", "boxes", "key", "occluded", "score")
_OPTIONAL: Final = ("labels", "ignore", "silent")
_TYPES: Final[JsonObject] = {
    "frames": np.int64,
    "boxes": np.float64,
    "key": np.bool_,
    "occluded": np.bool_,
    "score": np.float64,
    "labels": np.int64,
    "ignore": np.bool_,
    "silent": np.bool_,
}


def write_dataset_npz(path: Path, dataset: Dataset) -> int:
    """Write a data set of one video; return the number of its tracks.

    Args:
        path: the new file.
        dataset: its tracks fit into memory.
    """
    video = dataset.videos[0]
    tracks = list(video.tracks())
    metadata = {
        "tracks": [[t.uid, t.label, len(t.frames), t.state, t.source, list(map(list, t.notes))] for t in tracks],
        "skipped": [[each.what, each.reason] for each in dataset.skipped],
        "repaired": list(dataset.repaired),
        "provenance": dict(video.provenance),
        "labels": dump_set(dataset.labels),
        "attributes": [dict(track.attributes) for track in tracks],
        "changing": [{name: values.tolist() for name, values in track.changing.items()} for track in tracks],
    }
    columns: dict[str, NDArray[np.generic]] = {"said": np.frombuffer(json.dumps(metadata).encode(), np.uint8)}
    for name in _REQUIRED:
        columns[name] = _joined([getattr(track, name) for track in tracks], name)
    for name in _OPTIONAL:
        values = [getattr(track, name) for track in tracks]
        columns[f"has_{name}"] = np.array([each is not None for each in values], np.bool_)
        columns[name] = _joined([each for each in values if each is not None], name)
    with path.open("xb") as file:
        np.savez(file, **columns)  # type: ignore[arg-type]
    return len(tracks)


def read_dataset_npz(path: Path, target: ImportTarget, name: str) -> Dataset:
    """Read the file and check all guarantees again, because the process that wrote it has read an untrusted file.

    Args:
        path: the file.
        target: what the reader got.
        name: name of the untrusted file, for messages.

    Raises:
        ImportFormatError: the data breaks a guarantee.
    """
    with zipfile.ZipFile(path) as archive:
        if any(entry.compress_type != zipfile.ZIP_STORED for entry in archive.infolist()):
            raise ImportFormatError(f"{name}: the importing process returned unknown arrays.")
    with np.load(path, allow_pickle=False) as file:
        metadata = json.loads(file["said"].tobytes())
        columns: dict[str, NDArray[np.generic]] = {
            column: np.asarray(file[column], _TYPES[column]) for column in (*_REQUIRED, *_OPTIONAL)
        }
        is_present = {column: np.asarray(file[f"has_{column}"], np.bool_).tolist() for column in _OPTIONAL}
    take = {column: _sequential_slices(values) for column, values in columns.items()}

    def make_track(
        index: int, uid: str, label: int, count: int, state: str, source: str, notes: list[tuple[int, str]]
    ) -> Track:
        arrays: JsonObject = {column: take[column](count) for column in _REQUIRED}
        arrays |= {column: take[column](count) for column in _OPTIONAL if is_present[column][index]}
        texts = tuple((int(frame), str(text)) for frame, text in notes)
        attributes = parse_attributes(metadata["attributes"][index], name, None)
        changing = {
            str(each): _frame_values(values, count, name) for each, values in metadata["changing"][index].items()
        }
        return Track(
            uid=str(uid),
            label=int(label),
            **arrays,
            state=str(state),
            source=str(source),
            notes=texts,
            attributes=attributes,
            changing=changing,
        )

    tracks = [make_track(index, *row) for index, row in enumerate(metadata["tracks"])]
    video: DatasetVideo = replace(target.video, tracks=lambda: iter(tracks), provenance=dict(metadata["provenance"]))
    skipped = tuple(Skipped(str(what), str(reason)) for what, reason in metadata["skipped"])
    labels = parse_set(str(metadata["labels"]), name)
    if labels.labels[: len(target.labels)] != target.labels.labels and target.unknown != "add":
        raise ImportFormatError(f"{name}: the importing process returned labels that the set does not have.")
    dataset = Dataset(labels, (video,), skipped, tuple(map(str, metadata["repaired"])))
    check_dataset(dataset, target, name)
    return dataset


def _frame_values(values: object, count: int, name: str) -> NDArray[np.object_]:
    """Answers by frame, checked to be values of attributes."""
    out = np.full(count, None, object)
    if not isinstance(values, list) or len(values) != count:
        raise ImportFormatError(f"{name}: the importing process returned invalid attributes.")
    out[:] = [parse_attributes({"": value}, name, None).get("") for value in values]
    return out


def _joined(parts: list[NDArray[np.generic]], name: str) -> NDArray[np.generic]:
    empty: NDArray[np.generic] = np.zeros((0, 4) if name == "boxes" else 0, _TYPES[name])
    return np.concatenate([empty, *parts])


def _sequential_slices(values: NDArray[np.generic]) -> Callable[[int], NDArray[np.generic]]:
    position = 0

    def take(count: int) -> NDArray[np.generic]:
        nonlocal position
        position += count
        return values[position - count : position]

    return take
