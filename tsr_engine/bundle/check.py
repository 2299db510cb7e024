"""Checks a bundle and prepares it for a library; the server does this in a process with resource limits.

All steps that a hostile file can attack happen here: unpacking, decoding, reading an untrusted database. Afterwards the
folder holds

* ``bundle/``: the unpacked bundle; all files match the hashes of the manifest;
* ``evidence/``: its evidence, rewritten record by record with the clip's frame numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np

from tsr_engine.bundle.clip import picture_digest
from tsr_engine.bundle.evidence_slice import write_slice
from tsr_engine.bundle.layout import EVIDENCE
from tsr_engine.bundle.load import Bundle, open_evidence, read_bundle
from tsr_engine.errors import EvidenceError, ImportFormatError
from tsr_engine.evidence import EvidenceReader, VideoIdentity
from tsr_engine.io.video import VideoLimits, open_video
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.model import MAX_LABELS
from tsr_engine.records import EventKind, FrameEvidence, TrackState
from tsr_engine.track_table import SOURCES

_STATES, _EVENT_KINDS = get_args(TrackState), get_args(EventKind)


def check_and_unpack(
    path: Path, folder: Path, limits: VideoLimits, on_manifest: Callable[[Bundle], object] = lambda _: None
) -> JsonObject:
    """Check a bundle as a whole.

    Args:
        path: the zip file.
        folder: exists and is empty.
        limits: limits on the clip.
        on_manifest: called after the manifest has been read, before the clip is decoded.

    Returns:
        Facts: ``frames`` (of the clip), ``other_pictures``, ``tracks`` (track -> first and last frame in the clip).

    Raises:
        ImportFormatError: not a bundle, hostile or damaged.
        VideoError: the clip cannot be decoded.
        EvidenceError: the evidence is damaged, or of another version.
    """
    unpacked = folder / "bundle"
    unpacked.mkdir()
    bundle = read_bundle(path, unpacked)
    on_manifest(bundle)
    frames, other_pictures = _decode(bundle, limits)
    tracks = _rewrite(bundle, folder / EVIDENCE)
    return {"frames": frames, "other_pictures": other_pictures, "tracks": tracks}


def _decode(bundle: Bundle, limits: VideoLimits) -> tuple[int, int]:
    """Decode the whole clip; return the numbers of its frames and of pictures that differ from the manifest."""
    info = bundle.manifest.clip
    digests = {frame.clip: frame.digest for frame in bundle.frames}
    count = other_pictures = 0
    with open_video(bundle.clip, limits=limits) as video:
        if (video.width, video.height) != (info.width, info.height):
            raise ImportFormatError(
                f"{bundle.name}: {info.file} has pictures of {video.width}x{video.height}, its manifest says "
                f"{info.width}x{info.height}. Create the bundle again."
            )
        for frame in video.frames():
            count += 1
            wanted = digests.pop(frame.ordinal, None)
            other_pictures += wanted is not None and picture_digest(frame.picture) != wanted
    if digests:
        raise ImportFormatError(f"{bundle.name}: {info.file} ends before frame {min(digests)}. Copy the bundle again.")
    return count, other_pictures


def _rewrite(bundle: Bundle, folder: Path) -> dict[str, tuple[int, int]]:
    """Rewrite the evidence with the clip's frame numbers, through the records, so that nothing else is copied."""
    info = bundle.manifest
    with open_evidence(bundle) as reader:
        header = reader.header
        first, last = reader.first_frame, reader.last_frame
        if (first, last) != (info.frames.start, info.frames.stop - 1):
            raise ImportFormatError(f"{bundle.name}: the evidence is of other frames. Create the bundle again.")
        for key in ("width", "height"):
            if header.frame_table.get(key) != getattr(info.clip, key):
                raise ImportFormatError(f"{bundle.name}: the evidence is of pictures of another size. Create it again.")
        clip = VideoIdentity(info.clip.file, info.clip.sha256, bundle.clip.stat().st_size)
        table = {**header.frame_table, "frames": info.frames.stop - info.clip.offset}
        new_header = replace(header, video=clip, frame_table=table)
        try:
            write_slice(
                reader,
                folder,
                info.frames.start,
                info.frames.stop,
                new_header,
                offset=info.clip.offset,
                on_frame=lambda frame: _check_frame(bundle, frame),
            )
        except (ValueError, TypeError, KeyError, AttributeError, OverflowError) as error:
            raise EvidenceError(f"{bundle.name}: the evidence is damaged ({type(error).__name__}).") from None
    with EvidenceReader(folder) as reader:
        return {str(t.track_id): (t.first_frame, t.last_frame) for t in reader.tracks() if t.confirmed}


def _check_frame(bundle: Bundle, frame: FrameEvidence) -> None:
    """Check the guarantees that the page relies on."""
    info = bundle.manifest.clip
    is_invalid = (frame.width, frame.height) != (info.width, info.height)
    is_invalid |= not np.isfinite(frame.seconds)
    for track in frame.tracks:
        is_invalid |= track.state not in _STATES or track.source not in SOURCES
        is_invalid |= not np.isfinite(track.box).all() or not 0 < track.track_id < 10**12
        if (recognition := track.recognition) is not None:
            classes = len(recognition.votes)
            is_invalid |= not (0 <= recognition.class_id < classes and 0 <= recognition.runner_up < classes)
            is_invalid |= recognition.probabilities.shape != recognition.votes.shape or classes > MAX_LABELS
    is_invalid |= any(event.kind not in _EVENT_KINDS for event in frame.events)
    is_invalid |= not np.isfinite(frame.detections.boxes).all()
    for region in frame.regions:
        height, width = region.pixels.shape[:2]
        is_invalid |= region.x < 0 or region.y < 0 or region.x + width > frame.width or region.y + height > frame.height
    if is_invalid:
        raise EvidenceError(f"{bundle.name}: the evidence of frame {frame.ordinal + info.offset} is damaged.")
