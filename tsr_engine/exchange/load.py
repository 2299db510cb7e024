"""Imports a data set: unpacks, recognises, reads and checks it."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import ExportError, ImportFormatError, InputError, UsageError
from tsr_engine.exchange.archive import unpack
from tsr_engine.exchange.check_track import check_track
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Track
from tsr_engine.exchange.formats import Format, ImportTarget
from tsr_engine.exchange.gc_threshold import infrequent_gc
from tsr_engine.exchange.manifest import MANIFEST
from tsr_engine.exchange.nearby_manifest import ManifestSummary, find_manifest, visible_entries
from tsr_engine.exchange.negatives import with_negatives
from tsr_engine.exchange.registry import FORMATS, complete_switches
from tsr_engine.exchange.small_file_store import SmallFileStore
from tsr_engine.exchange.untrusted_zip import is_archive
from tsr_engine.io.atomic import storage_error
from tsr_engine.json_shapes import JsonMapping
from tsr_engine.track_table import NO_CLASS


def read_dataset(
    path: Path, target: ImportTarget, format: Format | None = None, *, scratch: Path | None = None
) -> Dataset:
    """Read a file, ZIP archive or folder of another tool and match it to a video.

    Args:
        path: what to read.
        target: the video, the labels and the switches; missing switches take their defaults.
        format: unset: recognise it by the content.
        scratch: folder for temporary files; unset: the system's.

    Returns:
        One video with its tracks in memory, with its run if a manifest of ours names it, and with the lists of skipped
        and repaired items.

    Raises:
        ImportFormatError: the format is unknown, or a rule is broken; names file, line and rule.
        UsageError: a wrong switch, or a format without a reader.
        InputError: ``path`` does not exist.
        StorageError: no space to unpack.
    """
    if not path.exists():
        raise InputError(f"There is no file or folder at {path}. Check the path.")
    if path.is_dir() or not is_archive(path):
        with infrequent_gc():
            return _read(path, path.name, target, format)
    try:
        with infrequent_gc(), tempfile.TemporaryDirectory(prefix="tsr-import-", dir=scratch) as folder:
            # The folder gets the archive's name, because readers' messages contain it.
            unpacked = Path(folder) / "archive" / path.name
            unpacked.mkdir(parents=True)
            with SmallFileStore(unpacked, Path(folder) / "store") as store:
                unpack(path, unpacked, pictures=False, store=store)
                return _read(unpacked, path.name, replace(target, store=store), format)
    except OSError as error:
        raise storage_error(path, error) from None


def detect_format(path: Path, formats: dict[str, Format] | None = None) -> tuple[Format, Path] | None:
    """The format of a folder or file, and where it begins: archives often wrap everything in one more folder."""
    candidates = [path]
    current = path
    while current.is_dir() and len(candidates) < 4:
        entries = visible_entries(current)
        if len(entries) != 1:
            break
        current = entries[0]
        candidates.append(current)
    for candidate in candidates:
        for known in (FORMATS if formats is None else formats).values():
            if known.read is not None and known.sniff(candidate):
                return known, candidate
    return None


def _read(path: Path, name: str, target: ImportTarget, format: Format | None) -> Dataset:
    found = detect_format(path, None if format is None else {format.name: format})
    if found is None and format is None:
        titles = ", ".join(known.title for known in FORMATS.values() if known.read is not None)
        raise ImportFormatError(f"{name}: matches none of {titles}. Name its format, or convert it.")
    # A chosen format reads the file even if it does not recognise it: its message says best what is wrong.
    chosen, root = found if found is not None else (format, path)
    assert chosen is not None
    if chosen.read is None:
        raise UsageError(f"{chosen.title} is written only, not read. Choose another format.")
    target = replace(target, switches=_switches(chosen, target, named=format is not None))
    if root != path and root.is_dir():
        target = replace(target, wrapper=root.name)
    manifest = find_manifest(root) if root.is_dir() else None
    entry = None if manifest is None else manifest.entry(target.video)
    if manifest is not None and manifest.videos and entry is None:
        raise ImportFormatError(_wrong_video(name, manifest, target))
    dataset = chosen.read(root, target)
    if entry is not None and len(dataset.videos) == 1:
        dataset = _with_run(with_negatives(dataset, entry, target, MANIFEST), entry)
    check_dataset(dataset, target, name)
    return dataset


def _switches(chosen: Format, target: ImportTarget, *, named: bool) -> dict[str, str]:
    try:
        return complete_switches(chosen, dict(target.switches), reading=True)
    except UsageError as error:
        if named:
            raise
        raise UsageError(
            f"{error} The file is taken for {chosen.title}. If it is of another format, name it with format= "
            "(--format on the command line)."
        ) from None


def _with_run(dataset: Dataset, entry: JsonMapping) -> Dataset:
    """The data set with the run named in our manifest."""
    provenance = entry.get("provenance")
    run = provenance.get("run") if isinstance(provenance, dict) else None
    if not isinstance(run, dict):
        return dataset
    return replace(dataset, videos=(replace(dataset.videos[0], provenance={"run": run}),))


def _wrong_video(name: str, manifest: ManifestSummary, target: ImportTarget) -> str:
    """The refusal of an export of other videos, whose tracks could replace tracks of the same name."""
    videos = [str(entry.get("name", "another video")) for entry in manifest.videos]
    more = f" and {len(videos) - 3} more" if len(videos) > 3 else ""
    return (
        f"{name}: is an export of {', '.join(videos[:3])}{more}, not of {target.video.name}. Import it onto that "
        f"video. To import it onto this one, remove its {MANIFEST}."
    )


def check_dataset(dataset: Dataset, target: ImportTarget, name: str) -> None:
    """Check the guarantees of every track again after the reader.

    Args:
        dataset: the reader's result.
        target: what the reader got.
        name: the file's name, for messages.

    Raises:
        ImportFormatError: a guarantee of ``Track`` is broken; names the track.
    """
    if len(dataset.videos) != 1:
        raise ImportFormatError(f"{name}: has {len(dataset.videos)} videos, must have one. Import one at a time.")
    video, tracks = target.video, list(dataset.videos[0].tracks())
    labels = frozenset(label.id for label in dataset.labels)
    if _all_valid(tracks, video, labels):
        return
    seen: set[str] = set()
    for track in tracks:
        try:
            check_track(track, video, labels)
        except ExportError as error:
            raise ImportFormatError(f"{name}: {error}") from None
        if (track.boxes[:, :2] < 0).any() or (track.boxes[:, 2:] > (video.width, video.height)).any():
            raise ImportFormatError(f"{name}, track {track.uid!r}: a box reaches out of the picture. Correct it.")
        if track.uid in seen:
            raise ImportFormatError(f"{name}: two tracks are called {track.uid!r}. Give each its own name.")
        seen.add(track.uid)


def _all_valid(tracks: list[Track], video: DatasetVideo, labels: frozenset[int]) -> bool:
    """Whether all tracks keep their guarantees, checked together; on failure single checks name the track."""
    if not tracks or len({track.uid for track in tracks}) < len(tracks):
        return False
    counts = np.array([len(track.frames) for track in tracks])
    shaped = all(
        track.boxes.shape == (n, 4)
        and all(values is None or values.shape == (n,) for values in (*_track_columns(track), *track.changing.values()))
        for track, n in zip(tracks, counts.tolist(), strict=True)
    )
    if not shaped or not counts.all():
        return False
    frames = np.concatenate([track.frames for track in tracks])
    boxes = np.concatenate([track.boxes for track in tracks])
    same_track = np.ones(len(frames), np.bool_)
    same_track[np.cumsum(counts)[:-1]] = False  # the step from one track's last frame to the next track's first
    rising = (np.diff(frames, prepend=-1) > 0) | ~same_track
    within = (frames >= 0) & (frames < video.frames)
    edges = (0, 0, video.width, video.height)
    boxed = (boxes[:, :2] >= edges[:2]) & (boxes[:, 2:] <= edges[2:]) & (boxes[:, :2] < boxes[:, 2:])
    used = {track.label for track in tracks}
    used.update(*(np.unique(track.labels).tolist() for track in tracks if track.labels is not None))
    return bool(used - {NO_CLASS} <= labels and rising.all() and within.all() and boxed.all())


def _track_columns(track: Track) -> tuple[NDArray[np.generic] | None, ...]:
    return track.key, track.occluded, track.score, track.labels, track.ignore, track.silent
