"""Collects the contents of a bundle from a run at one moment."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

from app.bundles.corrections import label_keys, with_engine_label
from app.bundles.expectation import expectation_of
from app.edits.documents import TrackDoc
from app.exchange.dataset import Source
from app.exchange.engine_tracks import read_track_infos
from app.recordings.annotation import corrected_rows
from tsr_engine.bundle import Bounds, BundleReport, BundleRequest, read_expectation
from tsr_engine.bundle.lead_in import find_lead_in
from tsr_engine.errors import InputError, UsageError
from tsr_engine.evidence import EvidenceReader
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import VideoSource, display_path
from tsr_engine.json_shapes import JsonObject


def bundle_request(
    source: Source,
    out: Path,
    first: int,
    stop: int,
    *,
    note: str = "",
    tracks: Collection[str] = (),
    video: Path | None = None,
    expectation: Path | None = None,
    models: Sequence[Path] = (),
    table: FrameTable | None = None,
    max_eq7: float | None = None,
    recording: bool = True,
) -> BundleRequest:
    """Collect the contents of the bundle of a run.

    Args:
        source: the run with its corrections.
        out: the file to make.
        first: first frame.
        stop: frame after the last.
        note: the reporter's description.
        tracks: keys of the tracks with the problem; empty: all corrected tracks.
        video: path of the video; unset: its last known path.
        expectation: an ``expectation.json`` that replaces the expectation from the corrections.
        models: folders in which the run's models may be.
        table: the video's frame table.
        max_eq7: allowed error (Eq. 7) of a corrected box; unset: the default.
        recording: include a recording.

    Raises:
        InputError: the run was made by another program, or its video is missing.
        UsageError: the run has no track with one of the keys.
        ImportFormatError: ``expectation`` breaks a rule.
    """
    run_info = source.provenance["run"]
    if run_info["kind"] == "imported":
        raise InputError(f"{run_info['name']} was made by another program, so the engine cannot replay it.")
    path: VideoSource | None = source.video.path if video is None else video
    if path is None or not display_path(path).is_file():
        raise InputError(f"The video {source.video.name} is missing. Put it back, or name it with --video.")
    with EvidenceReader(source.folder) as reader:
        _require_known(reader, source, tracks)
        if expectation is not None:
            expected = read_expectation(expectation)
        else:
            bounds = Bounds() if max_eq7 is None else Bounds(eq7=max_eq7)
            expected = expectation_of(reader, source.documents, first, stop, tracks, bounds, source.classes)
        documents = _corrected_documents(reader, source, first, stop, tracks)
    return BundleRequest(
        evidence=source.folder,
        video=path,
        out=out,
        first=first,
        stop=stop,
        note=note,
        expectation=expected,
        corrections={"documents": documents, "labels": label_keys(documents, source.classes.labels)},
        corrected=corrected_rows(source.folder, source.documents, source.classes),
        classes=source.classes,
        tracks=tuple(sorted(tracks)),
        table=table,
        limits=source.video.limits,
        models=models,
        run_id=str(run_info.get("id", "")),
        run_name=str(run_info.get("name", "")),
        preset=str(run_info.get("preset", "")),
        kind=run_info["kind"],
        recording=recording,
    )


def _require_known(reader: EvidenceReader, source: Source, tracks: Collection[str]) -> None:
    numbers = {track.track_id for track in reader.tracks()} if tracks else set()
    for key in tracks:
        is_known = key in source.documents or (key.startswith("m") and key[1:].isdecimal() and int(key[1:]) in numbers)
        if not is_known:
            raise UsageError(f"The run has no track {key[:40]!r}. The engine's are called m1, m2 and so on.")


def _corrected_documents(
    reader: EvidenceReader, source: Source, first: int, stop: int, tracks: Collection[str]
) -> list[JsonObject]:
    """Documents with corrections in the frames, by key, with the engine's labels that the bundle's evidence lacks."""
    infos = read_track_infos(source.folder, source.classes.to_label)
    start = find_lead_in(reader, first).start
    labels = {number: info.label for number, info in infos.items()}
    present = {number for number, info in infos.items() if info.span[0] < stop and info.span[1] >= start}
    return [
        with_engine_label(document, labels, present).model_dump(mode="json")
        for key, document in sorted(source.documents.items())
        if (not tracks or key in tracks) and _touches(document, first, stop)
    ]


def _touches(document: TrackDoc, first: int, stop: int) -> bool:
    if document.gone and not document.segments:
        return True
    keys = document.frames()
    if keys and keys[0] < stop and keys[-1] >= first:
        return True
    return any(piece.first < stop and piece.last >= first for piece in document.segments)


def report_summary(report: BundleReport) -> JsonObject:
    """Convert a report to plain JSON values."""
    manifest = report.manifest
    return {
        "first": manifest.frames.first,
        "stop": manifest.frames.stop,
        "lead_in": manifest.frames.first - manifest.frames.start,
        "whole_lead_in": manifest.frames.whole_lead_in,
        "note": manifest.note,
        "tracks": manifest.tracks,
        "expected": [
            {"id": one.id, "expected": one.expected, "met": one.met, "got": one.got, "frame": one.frame}
            for one in report.findings
        ],
        "clip": manifest.clip.how,
        "models": manifest.models,
        "recording": manifest.recording,
        "warnings": list(report.warnings),
        "files": len(manifest.files) + 1,
    }
