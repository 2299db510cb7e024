"""Stores a data set's tracks as corrections of a run, as one operation with one undo."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from sqlalchemy.orm import Session

from app.edits.bulk import BulkEdits
from app.edits.documents import TrackDoc
from app.exchange.as_annotation import AnnotationResult, annotate
from app.exchange.dataset import Source
from app.exchange.engine_tracks import read_track_infos
from app.exchange.tracks import run_tracks
from tsr_engine.exchange.dataset import Track


def annotate_run(
    edits: BulkEdits,
    source: Source,
    run_id: str,
    tracks: Sequence[Track],
    author: str,
    command: Mapping[str, object],
    *,
    exported: bool = False,
    begin: Callable[[Session], None] | None = None,
) -> tuple[AnnotationResult, int | None]:
    """Make a run show tracks.

    Args:
        edits: the run's log.
        source: the run, as read before.
        run_id: its id.
        tracks: the tracks; see :func:`app.exchange.as_annotation.annotate`.
        author: author of the corrections.
        command: the command to log.
        exported: the tracks come from an export of this run, so match them by name only.
        begin: called first in the transaction that stores them.

    Returns:
        The result for the tracks, and the number of the operation in the log; None: nothing has changed.
    """
    size = source.video.width, source.video.height
    before = {track.uid: track for track in source.tracks()}
    result = AnnotationResult()
    engine = read_track_infos(source.folder, source.classes.to_label)

    def make(current: Mapping[str, TrackDoc]) -> Mapping[str, TrackDoc]:
        nonlocal result
        shown = before
        if dict(current) != dict(source.documents):  # changed since it was read
            frames = source.video.frames
            current_tracks = run_tracks(
                source.folder, current, source.first, source.stop, frames, source.origin, source.classes.to_label
            )
            shown = {track.uid: track for track in current_tracks}
        result = annotate(tracks, shown, current, author, size, exported, engine)
        return result.documents

    seq = edits.put_documents(run_id, author, command, make, begin)
    return result, seq
