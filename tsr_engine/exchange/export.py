"""Exports a data set in one format: checks, writes and describes it, then gives it its name in one step."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from tsr_engine.errors import ExportError, StorageError
from tsr_engine.exchange.attributes import lost_attributes
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.filters import clip_dataset
from tsr_engine.exchange.formats import ExportOptions, Format
from tsr_engine.exchange.gc_threshold import infrequent_gc
from tsr_engine.exchange.manifest import MANIFEST, Manifest, build_manifest, count_tracks
from tsr_engine.exchange.negatives import move_rejected
from tsr_engine.exchange.output_sink import FolderSink, OutputSink, ZipSink
from tsr_engine.exchange.publish import fsync_tree, publish, staging_folder
from tsr_engine.exchange.registry import complete_switches
from tsr_engine.exchange.relabel import resolve_merged_labels
from tsr_engine.exchange.split import check_leaks
from tsr_engine.io.atomic import storage_error
from tsr_engine.json_shapes import JsonMapping

CROP_FORMATS = frozenset({"gtsrb"})
"""Formats that crop signs from their frames: a frame may serve two subsets."""


def export_dataset(
    dataset: Dataset,
    format: Format,
    out: Path,
    options: ExportOptions | None = None,
    *,
    zipped: bool,
    about: JsonMapping | None = None,
) -> Manifest:
    """Write a data set to a folder or ZIP file, which appears complete or not at all.

    An older export of that name stays complete until one rename replaces it. A process that is killed leaves at most a
    hidden sibling, which the next export to the same name removes.

    Args:
        dataset: what to write; its tracks are read several times. Rejected tracks are written into the manifest, and
            into a format's own place for them if it has one, but never as signs.
        format: must have a writer.
        out: the folder, or with ``zipped`` the file; an older export is replaced, anything else is refused.
        options: unset: no pictures. Missing switches take their defaults.
        zipped: write one ZIP file, with the same bytes for the same data.
        about: the caller's request, stored in the manifest as ``asked``.

    Returns:
        The manifest, as written.

    Raises:
        ExportError: the format cannot hold the data, a track breaks a guarantee, or the split leaks.
        UsageError: an option that the format does not have.
        StorageError: no space or no permission, or ``out`` exists and is not an export.
    """
    options = ExportOptions() if options is None else options
    write = format.write
    if write is None:
        raise ExportError(f"{format.title} can only be imported. Choose another format.")
    format.check_pictures(options.pictures)
    options = replace(options, switches=complete_switches(format, dict(options.switches), reading=False))
    _check_target(out, zipped)
    dataset = resolve_merged_labels(dataset)
    counts = count_tracks(dataset, options)
    signs = move_rejected(clip_dataset(dataset), counts.negatives)
    check_leaks(dataset, options.split, whole_frames=format.name not in CROP_FORMATS)
    try:
        with staging_folder(out) as folder, infrequent_gc():

            def write_into(sink: OutputSink) -> Manifest:
                skipped, extra = write(signs, sink, options)
                all_skipped = [*dataset.skipped, *counts.skipped, *skipped]
                if format.attributes != "all":
                    all_skipped += lost_attributes(signs, all_of_them=format.attributes == "none", title=format.title)
                manifest = build_manifest(signs, format, options, counts, all_skipped, extra, sink.files, about or {})
                sink.put(MANIFEST, manifest.encoded())
                return manifest

            if zipped:
                output = folder / "export.zip"
                with output.open("xb") as stream:
                    report_progress = partial(options.progress, counts.tracks, counts.tracks)
                    with ZipSink(stream, folder, report_progress) as archive:
                        manifest = write_into(archive)
            else:
                output = folder / "export"
                output.mkdir()
                manifest = write_into(FolderSink(output))
            fsync_tree(output)
            publish(output, out)
    except OSError as error:
        raise storage_error(out, error) from None
    return manifest


def _check_target(out: Path, zipped: bool) -> None:
    if zipped and out.is_dir():
        raise StorageError(f"Cannot write {out}: it is a folder. Name a file.")
    if not zipped and out.exists():
        if not out.is_dir():
            raise StorageError(f"Cannot write {out}: it is a file. Name a folder.")
        if not (out / MANIFEST).is_file() and any(out.iterdir()):
            raise StorageError(
                f"{out} has files but is not an earlier export, so nothing was written. Name another folder."
            )
