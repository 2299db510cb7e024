"""Chooses a peer's settings on clips that it is not judged on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from benchmarks.cache import Cache
from benchmarks.experiment import version
from benchmarks.peers.figures import sequence, trackeval_figures
from benchmarks.peers.multi_object_trackers import PACKAGE, Peer, load, track_with_peer
from benchmarks.videos.stored_detections import DetectedVideo

ORDER = ("HOTA", "MOTA", "IDF1")
"""Figures by which a combination is chosen; a later one decides if the earlier ones are equal."""
_DIGITS = 9
"""Number of decimals in which equal figures agree, since the order of sums may differ."""


@dataclass(frozen=True, slots=True)
class Tuned:
    """The best settings.

    Attributes:
        settings: a combination of the peer's grid.
        hota: HOTA on the tuning videos.
        tried: number of combinations.
        equal: number of combinations with that HOTA.
    """

    settings: dict[str, float]
    hota: float
    tried: int
    equal: int


def tune(peer: Peer, clips: Sequence[DetectedVideo], cache: Cache) -> Tuned:
    """Find the combination with the highest HOTA over all videos together; MOTA, then IDF1, decide on a tie.

    Args:
        peer: the tracker to tune.
        clips: the videos with their detections.
        cache: store of earlier results.

    Raises:
        Missing: the peer or TrackEval is not installed.
        ValueError: there are no clips, or the grid is empty.
    """
    load("trackeval")
    if not clips:
        raise ValueError(f"{peer.name} cannot be tuned: expected at least one clip, got none. Name the clips' folder.")
    grid = {name: list(values) for name, values in peer.grid.items()}
    versions = version(PACKAGE), version("trackeval")
    inputs = ["tuned", ORDER, peer.name, grid, *versions, [c.video.digests() for c in clips]]
    return Tuned(**cache.get(inputs, lambda: asdict(_search(peer, clips))))


def _search(peer: Peer, clips: Sequence[DetectedVideo]) -> Tuned:
    known: dict[tuple[bytes, ...], tuple[float, ...]] = {}
    combinations = list(peer.settings())
    reached: list[tuple[float, ...]] = []
    for settings in combinations:
        found = [track_with_peer(peer, s, settings)[0] for s in clips]
        # Neighbouring settings often give the same rows.
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
