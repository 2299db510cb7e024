"""Reads and writes ``manifest.json``: the content of an export, its origin, and the hash of every file."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from tsr_engine.errors import ExportError, ImportFormatError
from tsr_engine.exchange.check_track import check_track
from tsr_engine.exchange.dataset import REJECTED, Dataset, DatasetVideo, Skipped, Track
from tsr_engine.exchange.filters import clip_track, select_frames
from tsr_engine.exchange.formats import ExportOptions, Format
from tsr_engine.exchange.negatives import negative_as_json
from tsr_engine.exchange.pictures import WrittenPicture, wanted_frames
from tsr_engine.exchange.reading import read_json
from tsr_engine.exchange.split import Split, missing_labels, subset_of
from tsr_engine.exchange.video_names import video_names
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.labels.files import DEFAULT, shipped_set
from tsr_engine.labels.model import Label, LabelSet
from tsr_engine.plural import plural
from tsr_engine.track_table import NO_CLASS
from tsr_engine.version import __version__

MANIFEST = "manifest.json"
VERSION = 1
"""Version of the layout; readers ignore unknown keys."""


@dataclass(frozen=True, slots=True)
class TrackCounts:
    """The result of one pass over the tracks.

    Attributes:
        tracks: number of exported tracks of signs.
        boxes: number of their boxes.
        negatives: per video, the exported rejected tracks, clipped at the picture.
        annotated: per video, the frames with a box of a sign.
        counts: subset -> class name -> ``{"tracks": n, "boxes": n}``.
        skipped: tracks that are in no subset of the split, and boxes outside the picture.
        repaired: boxes that were clipped at the picture.
    """

    tracks: int
    boxes: int
    negatives: list[tuple[Track, ...]]
    annotated: list[NDArray[np.int64]]
    counts: dict[str, dict[str, dict[str, int]]]
    skipped: list[Skipped]
    repaired: list[str]


@dataclass(frozen=True, slots=True)
class Manifest:
    """The content of ``manifest.json``.

    Attributes:
        content: plain JSON values as written.
    """

    content: JsonObject = field(default_factory=dict)

    @property
    def files(self) -> list[JsonObject]:
        """``{"name", "size", "sha256"}`` of every file but the manifest, sorted by name."""
        return list(self.content["files"])

    @property
    def skipped(self) -> list[dict[str, str]]:
        """``{"what", "reason"}`` of everything that was not exported."""
        return list(self.content["skipped"])

    @property
    def counts(self) -> JsonObject:
        """Number of videos, tracks, boxes and rejected tracks, and the counts of each class in each subset."""
        return dict(self.content["counts"])

    def encoded(self) -> bytes:
        """The bytes of ``manifest.json``: sorted keys, one line per top-level key."""
        lines = [f"{json.dumps(key)}: {_dump(value)}" for key, value in sorted(self.content.items())]
        return ("{\n" + ",\n".join(lines) + "\n}\n").encode()


def count_tracks(dataset: Dataset, options: ExportOptions) -> TrackCounts:
    """Check and count all tracks in one pass.

    Raises:
        ExportError: a track breaks a guarantee, or two tracks of a video have the same name.
    """
    counts: dict[str, dict[str, dict[str, int]]] = {}
    names = {label.id: label.name for label in dataset.labels} | {NO_CLASS: ""}
    annotated: list[NDArray[np.int64]] = []
    negatives: list[tuple[Track, ...]] = []
    tracks = boxes = left_out = clipped = outside = 0
    for video in dataset.videos:
        has_sign = np.zeros(video.frames, dtype=np.bool_)
        seen: set[str] = set()
        rejected: list[Track] = []
        for track in video.tracks():
            check_track(track, video, names)
            if track.uid in seen:
                raise ExportError(f"{video.name}: two tracks are called {track.uid!r}. Give each its own name.")
            seen.add(track.uid)
            subset = subset_of(video, track.uid, options.split)
            if subset is None:
                left_out += 1
                continue
            inside, clipped_boxes = clip_track(track, (video.width, video.height))
            clipped += clipped_boxes
            outside += len(track.frames) - (0 if inside is None else len(inside.frames))
            if inside is None:
                continue
            if track.state == REJECTED:
                rejected.append(inside)
                continue
            tracks, boxes = tracks + 1, boxes + len(inside.frames)
            has_sign[inside.frames] = True
            entry = counts.setdefault(subset, {}).setdefault(names[track.label], {"tracks": 0, "boxes": 0})
            entry["tracks"] += 1
            entry["boxes"] += len(inside.frames)
        annotated.append(np.flatnonzero(has_sign).astype(np.int64))
        negatives.append(tuple(rejected))
    skipped = [Skipped(plural(left_out, "track"), "They are on no side of the split.")] if left_out else []
    skipped += [Skipped(plural(outside, "box", "boxes"), "They lie outside of the picture.")] if outside else []
    repaired = [f"Boxes that reached over the edge of the picture were cut there: {clipped}."] if clipped else []
    return TrackCounts(tracks, boxes, negatives, annotated, counts, skipped, repaired)


def build_manifest(
    dataset: Dataset,
    format: Format,
    options: ExportOptions,
    counts: TrackCounts,
    skipped: Iterable[Skipped],
    extra: JsonMapping,
    files: list[JsonObject],
    request: JsonMapping,
) -> Manifest:
    """Build the manifest.

    Args:
        dataset: the exported data; its videos hold their negatives.
        format: the format written.
        options: of the export.
        counts: counts of ``count_tracks``.
        skipped: what was not exported.
        extra: the writer's entries; its ``pictures`` are ``WrittenPicture`` and go into the frame tables.
        files: name, size and hash of each.
        request: the caller's request.
    """
    entries = dict(extra)
    pictures: Sequence[WrittenPicture] = entries.pop("pictures", ())
    by_video: dict[int, dict[int, WrittenPicture]] = {}
    for picture in pictures:
        by_video.setdefault(picture.video, {})[picture.frame] = picture
    kind = options.pictures if options.pictures != "none" else "annotated"
    split = options.split
    content = {
        "manifest": VERSION,
        "tool": {"name": "tsr", "version": __version__},
        "format": {"name": format.name, "title": format.title, "switches": dict(options.switches), **entries},
        "coordinates": "frames count from 0 in presentation order; px edges from 0, right and lower edge exclusive",
        "pictures": options.pictures,
        "thin_px": options.thin_px,
        "label_set": {"key": dataset.labels.key, "name": dataset.labels.name, "version": dataset.labels.version},
        "classes": [_class(label) for label in dataset.labels],
        "split": {
            "rule": split.rule if isinstance(split, Split) else ("given" if split else "none"),
            "seed": split.seed if isinstance(split, Split) else None,
            "shares": dict(split.shares) if isinstance(split, Split) else {},
            "groups": split.groups if isinstance(split, Split) else None,
            "lacks": missing_labels(dataset, split),
            "tracks": [[video, uid, subset] for (video, uid), subset in sorted(split.items())],
        },
        "counts": {
            "videos": len(dataset.videos),
            "tracks": counts.tracks,
            "boxes": counts.boxes,
            "negatives": sum(map(len, counts.negatives)),
            "pictures": len(pictures) + entries.get("crops", 0),
            "classes": counts.counts,
        },
        "videos": [
            _video(video, export_name, wanted_frames(video, counts.annotated[index], kind), by_video.get(index, {}))
            | (
                {"negatives": [negative_as_json(track, dataset.labels) for track in video.negatives]}
                if video.negatives
                else {}
            )
            | {"left_out": _left_out(video, format)}
            for index, (video, export_name) in enumerate(zip(dataset.videos, video_names(dataset.videos), strict=True))
        ],
        "skipped": [{"what": item.what, "reason": item.reason} for item in skipped],
        "repaired": [*dataset.repaired, *counts.repaired],
        "asked": dict(request),
        "files": files,
    }
    return Manifest(content)


def _class(label: Label) -> JsonObject:
    """A label with what training from the export needs: the model's label, and what the label teaches."""
    known = shipped_set(DEFAULT).by_key(label.key) is not None
    return {
        "id": label.id,
        "key": label.key,
        "name": label.name,
        **({"aliases": list(label.aliases)} if label.aliases and not known else {}),
        **({} if label.teach == "sign" else {"teach": label.teach}),
        **({} if label.merged_into is None else {"merged_into": label.merged_into}),
    }


def labels_of(content: JsonMapping) -> LabelSet:
    """The labels of an export, without other facts about its set.

    Raises:
        ImportFormatError: they are not labels of one set.
    """
    benchmark = {label.name: label.key for label in shipped_set(DEFAULT)}
    set_info = content.get("label_set", {})
    try:
        # Exports of version 0.1 have no keys.
        labels = tuple(
            Label(
                id=each["id"],
                key=each.get("key") or benchmark.get(each["name"], each["name"]),
                name=each["name"],
                aliases=tuple(each.get("aliases", ())),
                teach=each.get("teach", "sign"),
                merged_into=each.get("merged_into"),
            )
            for each in content["classes"]
        )
        return LabelSet(
            key=set_info.get("key", DEFAULT),
            name=set_info.get("name", DEFAULT),
            version=set_info.get("version", 1),
            next_id=max((label.id for label in labels), default=NO_CLASS) + 1,
            labels=labels,
        )
    except (KeyError, TypeError, AttributeError, ValidationError):
        raise ImportFormatError(f"{MANIFEST}: its classes are not labels of one set. Export again.") from None


def read_manifest(folder: Path) -> Manifest:
    """Read the manifest of an export.

    Raises:
        ImportFormatError: there is none, or another tool wrote it.
    """
    path = folder / MANIFEST
    if not path.is_file():
        raise ImportFormatError(
            f"{folder} has no {MANIFEST}, so it is not an export of this tool. Choose another folder."
        )
    content = read_json(path)
    if not isinstance(content, dict) or content.get("manifest") != VERSION or "files" not in content:
        raise ImportFormatError(f"{path}: is not a manifest of version {VERSION}. Export again.")
    return Manifest(content)


def _video(
    video: DatasetVideo, export_name: str, frames: NDArray[np.int64], pictures: Mapping[int, WrittenPicture]
) -> JsonObject:
    """A video with its frame table as columns: rows would be ten times as large."""
    table: JsonObject = {"frame": frames.tolist()}
    if video.times is not None:
        table["time_ms"] = np.round(video.times[frames] * 1000.0, 3).tolist()
    if pictures:
        rows = [pictures.get(frame) for frame in table["frame"]]
        table["file"] = [None if row is None else row.file for row in rows]
        table["picture_sha256"] = [None if row is None else row.sha256 for row in rows]
    return {
        "name": video.name,
        "called": export_name,
        "sha256": video.sha256,
        "width": video.width,
        "height": video.height,
        "pixel_ratio": f"{video.pixel_ratio.numerator}/{video.pixel_ratio.denominator}",
        "frames": video.frames,
        "rate": None if video.rate is None else f"{video.rate.numerator}/{video.rate.denominator}",
        "constant_rate": video.constant_rate,
        "first": video.first,
        "stop": video.stop or video.frames,
        "provenance": dict(video.provenance),
        "frame_table": table,
    }


def _left_out(video: DatasetVideo, format: Format) -> list[JsonObject]:
    """Places without a box of the export that a retraining must not take for background.

    An empty list tells it that there are none: manifests of earlier versions have no list.
    """
    tracks = list(video.left_out)
    if not format.ignores:  # its writer drops regions to ignore
        ignored = (select_frames(track, track.ignore) for track in video.tracks() if track.ignore is not None)
        tracks += [track for track in ignored if track is not None]
    return [{"frames": track.frames.tolist(), "boxes": track.boxes.round(1).tolist()} for track in tracks]


def _dump(value: object) -> str:
    return json.dumps(value, allow_nan=False, separators=(",", ":"), sort_keys=True)
