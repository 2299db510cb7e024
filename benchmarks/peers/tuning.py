"""Choosing a peer's settings on clips that it is not judged on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from benchmarks.peers.cache import Cache
from benchmarks.peers.figures import sequence, trackeval_figures
from benchmarks.peers.multi import PACKAGE, Peer, load, rows_of, version
from benchmarks.peers.seen import Seen

__all__ = ["Tuned", "tune"]

ORDER = ("HOTA", "MOTA", "IDF1")
"""What a combination is chosen by: the later ones decide where the earlier are equal."""
_DIGITS = 9
"""Figures that agree to so many decimals are equal: sums come in another order."""


@dataclass(frozen=True, slots=True)
class Tuned:
    """The settings that did best.

    Attributes:
        settings: a combination of the peer's grid.
        hota: on the videos that it was chosen on.
        tried: number of combinations.
        equal: how many of them reach that HOTA.
    """

    settings: dict[str, float]
    hota: float
    tried: int
    equal: int


def tune(peer: Peer, clips: Sequence[Seen], kept: Cache) -> Tuned:
    """The combination with the highest HOTA over all videos together; of equal ones the best by MOTA, then by IDF1.

    Args:
        peer: what is tuned.
        clips: the videos, with the detections that it gets.
        kept: where earlier answers are.

    Raises:
        Missing: the peer or TrackEval is not installed.
        ValueError: no clips, or an empty grid.
    """
    load("trackeval")
    if not clips:
        raise ValueError(f"{peer.name} cannot be tuned: expected at least one clip, got none. Name the clips' folder.")
    grid = {name: list(values) for name, values in peer.grid.items()}
    versions = version(PACKAGE), version("trackeval")
    made_from = ["tuned", ORDER, peer.name, grid, *versions, [c.video.identity() for c in clips]]
    return Tuned(**kept.get(made_from, lambda: asdict(_search(peer, clips))))


def _search(peer: Peer, clips: Sequence[Seen]) -> Tuned:
    known: dict[tuple[bytes, ...], tuple[float, ...]] = {}
    combinations = list(peer.settings())
    reached: list[tuple[float, ...]] = []
    for settings in combinations:
        found = [rows_of(peer, s, settings)[0] for s in clips]
        # Neighbouring settings often come to the very same rows.
        same = tuple(part.tobytes() for rows in found for part in (rows.frame, rows.track, rows.boxes))
        if same not in known:
            videos = [sequence(s.video.truth, rows, len(s.frames)) for s, rows in zip(clips, found, strict=True)]
            figures = trackeval_figures(videos, ORDER)
            known[same] = tuple(round(figures[name], _DIGITS) for name in ORDER)
        reached.append(known[same])
    if not reached:
        raise ValueError(f"{peer.name} has an empty grid. Name at least one value of each setting.")
    best = max(range(len(reached)), key=reached.__getitem__)
    equal = sum(figures[0] == reached[best][0] for figures in reached)
    return Tuned(combinations[best], reached[best][0], len(combinations), equal)
