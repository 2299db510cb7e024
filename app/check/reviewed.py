"""People's decisions about a drive, as ground truth for measurements."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from app.exchange.dataset import Source
from tsr_engine.evaluation.track_tables import result_table
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.exchange.dataset import REJECTED, Track
from tsr_engine.exchange.frame_rows import table_of
from tsr_engine.track_table import TrackTable


@dataclass(frozen=True, slots=True)
class ReviewedDrive:
    """A drive that people have reviewed.

    Attributes:
        source: the run with its corrections.
        truth: ground truth: signs that people have accepted or drawn; undecided tracks are marked as ignored.
        results: the run's own results without the corrections; classes are labels of the video's set.
        decided: number of tracks that people have accepted, drawn or rejected.
    """

    source: Source
    truth: TrackTable
    results: TrackTable
    decided: int


def reviewed_drive(source: Source) -> ReviewedDrive | None:
    """Convert a reviewed run to ground truth; None if people have decided nothing about it.

    A track counts if a person accepted it, or changed or drew it and did not mark it as needing work. A rejected or
    deleted track is no sign: a result there is a false track. All other tracks are ignored: results there are neither
    right nor wrong.
    """
    tracks = list(source.tracks())
    rejected = [track for track in tracks if track.state == REJECTED]
    signs = [track for track in tracks if track.state != REJECTED]
    counted = [_counts(track) for track in signs]
    gone = sum(document.gone for document in source.documents.values())
    decided = sum(counted) + len(rejected) + gone
    if not decided:
        return None
    with EvidenceReader(source.folder) as reader:
        results = result_table(row for row in reader.result_rows() if source.first <= row.frame < source.stop)
    results = replace(results, class_id=source.classes.to_labels(results.class_id))
    return ReviewedDrive(source, _truth(signs, counted), results, decided)


def _counts(track: Track) -> bool:
    return track.state == "accepted" or (track.source in ("human", "corrected") and track.state == "open")


def _truth(tracks: list[Track], counted: list[bool]) -> TrackTable:
    table = table_of(tracks)
    return replace(table, ignore=table.ignore | table.occluded | ~np.array(counted, np.bool_)[table.track])
