"""Checks the guarantees that ``Track`` gives to writers."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from tsr_engine.errors import ExportError
from tsr_engine.exchange.dataset import DatasetVideo, Track
from tsr_engine.track_table import NO_CLASS


def check_track(track: Track, video: DatasetVideo, labels: Collection[int]) -> None:
    """Check the guarantees of ``Track``; ``labels`` are the ids of the set.

    Raises:
        ExportError: the track breaks one; names video, track and frame.
    """

    def rule_error(rule: str) -> ExportError:
        return ExportError(f"{video.name}, track {track.uid!r}: {rule} Correct the track, or leave it out.")

    n = len(track.frames)
    if n == 0:
        raise rule_error("has no boxes.")
    for name in ("key", "occluded", "score", "labels", "ignore", "silent"):
        values = getattr(track, name)
        if values is not None and values.shape != (n,):
            raise rule_error(f"{name} has shape {values.shape}, must have ({n},).")
    if track.boxes.shape != (n, 4):
        raise rule_error(f"boxes have shape {track.boxes.shape}, must have ({n}, 4).")
    if n > 1 and not (np.diff(track.frames) > 0).all():
        raise rule_error("has two boxes in one frame, or frames out of order.")
    if track.frames[0] < 0 or track.frames[-1] >= video.frames:
        raise rule_error(f"frames {track.frames[0]} to {track.frames[-1]} must be in 0 to {video.frames - 1}.")
    bad = ~np.isfinite(track.boxes).all(axis=1)
    bad |= (track.boxes[:, 0] >= track.boxes[:, 2]) | (track.boxes[:, 1] >= track.boxes[:, 3])
    if bad.any():
        k = int(np.flatnonzero(bad)[0])
        raise rule_error(
            f"frame {track.frames[k]}: box {track.boxes[k].tolist()} must be finite with x1 < x2, y1 < y2."
        )
    if any(values.shape != (n,) for values in track.changing.values()):
        raise rule_error(f"has an attribute without {n} answers, one per frame.")
    used = {track.label} if track.labels is None else {track.label, *np.unique(track.labels).tolist()}
    strange = [label for label in used if label != NO_CLASS and label not in labels]
    if strange:
        raise rule_error(f"has the label {strange[0]}, an id that its set never had.")
