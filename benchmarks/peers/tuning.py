"""Choosing a peer's settings on clips that it is not judged on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from benchmarks.peers.figures import sequence, trackeval_figures
from benchmarks.peers.kept import Kept
from benchmarks.peers.multi import PACKAGE, Peer, load, rows_of, version
from benchmarks.peers.seen import Seen

__all__ = ["Tuned", "tune"]


@dataclass(frozen=True, slots=True)
class Tuned:
    """The settings that did best.

    Attributes:
        settings: a combination of the peer's grid.
        hota: on the clips that it was chosen on.
        tried: number of combinations.
    """

    settings: dict[str, float]
    hota: float
    tried: int


def tune(peer: Peer, clips: Sequence[Seen], kept: Kept) -> Tuned:
    """The combination with the highest HOTA over all clips together; of equal ones the first of the grid.

    Args:
        peer: what is tuned.
        clips: with the detections that it gets.
        kept: where earlier answers are.

    Raises:
        Missing: the peer or TrackEval is not installed.
        ValueError: no clips, or an empty grid.
    """
    load("trackeval")
    if not clips:
        raise ValueError(f"{peer.name} cannot be tuned: expected at least one clip, got none. Name the clips' folder.")
    grid = {name: list(values) for name, values in peer.grid.items()}
    made_from = ["tuned", peer.name, grid, version(PACKAGE), version("trackeval"), [c.video.identity() for c in clips]]
    return Tuned(**kept.get(made_from, lambda: asdict(_search(peer, clips))))


def _search(peer: Peer, clips: Sequence[Seen]) -> Tuned:
    best: Tuned | None = None
    known: dict[tuple[bytes, ...], float] = {}
    combinations = list(peer.settings())
    for settings in combinations:
        found = [rows_of(peer, s, settings)[0] for s in clips]
        # Neighbouring settings often come to the very same rows.
        same = tuple(part.tobytes() for rows in found for part in (rows.frame, rows.track_id, rows.boxes))
        if same not in known:
            videos = [sequence(s.video.truth, rows, len(s.frames)) for s, rows in zip(clips, found, strict=True)]
            known[same] = trackeval_figures(videos, ["HOTA"])["HOTA"]
        if best is None or known[same] > best.hota:
            best = Tuned(settings, known[same], len(combinations))
    if best is None:
        raise ValueError(f"{peer.name} has an empty grid. Name at least one value of each setting.")
    return best
