"""The figures of a comparison, each with its places. Definitions: docs/compare.md."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from pydantic import Field

from app.body_model import Model
from app.compare.pairs import Pair, PairFinder
from app.evidence.run_columns import IntColumn
from tsr_engine.evaluation.matching import Matching
from tsr_engine.json_shapes import JsonObject
from tsr_engine.track_table import TrackTable

MIN_WIDTH = 20.0
"""Minimum width of a sign that counts for coverage, identities and classes, px."""
MAX_PLACES = 500
"""Maximum number of places per figure; ``places`` holds their full number."""
ERROR_TOLERANCE = 1e-6
"""Eq. 7 of boxes that differ only by rounding."""
OF_CANDIDATE = frozenset({"precision", "switches", "false_tracks"})
"""Figures whose places lie on tracks of the candidate; the page's ``FIGURES`` says the same."""


class Figure(Model):
    """One number and the places that it comes from.

    A place is a range of frames of one track: ``frames[i]`` to ``lasts[i]`` of ``tracks[i]``. ``partners[i]`` is the
    other side's track in the first of them; None: there is none.
    """

    value: float | None
    """None: there is nothing to measure."""
    of: tuple[int, int] | None
    """Numerator and denominator, for shares."""
    frames: list[int]
    lasts: list[int]
    tracks: list[str]
    partners: list[str | None]
    places: int
    """Number of places, even if the lists are cut."""
    pairs: list[Pair] = Field([])
    """Both boxes in the first frame of each place."""
    errors: list[float] | None = None
    """Error of each place; set if the places are ordered by it."""


FIRST_UNKNOWN_LABEL = -10
"""Labels from here down are words of models that the label set lacks; -1 and -2 have other meanings."""


class Cell(Model):
    """Boxes of one reference label to which the candidate gives another label."""

    reference: int | None
    """None: nothing there; -1: a sign of none of the set's labels; below: see ``words`` of the matrix."""
    candidate: int | None
    """None: missed; -1: found, with none of the set's labels."""
    count: int
    frames: list[int]
    lasts: list[int]
    tracks: list[str]
    partners: list[str | None]
    pairs: list[Pair]


class Confusion(Model):
    """Matched boxes by label; missed ones have no candidate label, false ones no reference label."""

    classes: list[int]
    """Labels that occur, those below 0 last."""
    words: dict[int, str]
    """Words of models that the label set has no label for, by the number below -1 that replaces them here."""
    cells: list[Cell]


@dataclass(frozen=True, slots=True)
class _Sign:
    """One reference track that is wide enough to count."""

    key: str
    frames: IntColumn
    covered: IntColumn
    """Frames of ``frames`` with a match."""
    matched: IntColumn
    """All its matched frames."""
    tracks: IntColumn
    """The candidate's track in each of ``matched``."""
    right: bool


def figures(reference: TrackTable, candidate: TrackTable, found: Matching) -> dict[str, Figure]:
    """Compute all figures, by name."""
    signs = _signs(reference, candidate, found)
    seen = [sign for sign in signs if len(sign.matched)]
    ids = [list(dict.fromkeys(sign.tracks.tolist())) for sign in seen]
    wide = np.concatenate([sign.frames for sign in signs]) if signs else np.zeros(0)
    covered = sum(len(sign.covered) for sign in signs)
    switches = [
        (int(f), candidate.names[b])
        for sign in seen
        for f, (a, b) in zip(sign.matched[1:], pairwise(sign.tracks.tolist()), strict=True)
        if a != b
    ]
    second_ids = [
        (int(sign.matched[sign.tracks == tracks_of_sign[1]][0]), sign.key)
        for sign, tracks_of_sign in zip(seen, ids, strict=True)
        if tracks_of_sign[1:]
    ]
    used = set(candidate.track[found.candidate].tolist())
    false = _false_tracks(candidate, found, used)
    wrong = [(int(sign.matched[-1]), sign.key) for sign in seen if not sign.right]
    results = {
        "precision": _share(len(found.candidate), found.judged, _frame_ranges(candidate, found.false)),
        "recall": _share(len(found.reference), found.counted, _frame_ranges(reference, found.missed)),
        "eq7": _mean_error(reference, found),
        "coverage": _share(covered, len(wide), _uncovered(signs)),
        "fragmentation": _count(_interruptions(signs)),
        "switches": _count(switches),
        "ids_per_sign": _figure(
            sum(map(len, ids)) / len(ids) if ids else None, None, [(f, f, k) for f, k in second_ids]
        ),
        "signs_found": _share(
            len(seen), len(signs), [(int(s.frames[0]), int(s.frames[-1]), s.key) for s in signs if not len(s.matched)]
        ),
        "signs_classified": _share(len(seen) - len(wrong), len(seen), [(f, f, k) for f, k in wrong]),
        "false_tracks": _count(false),
    }
    of_reference = _Places(reference, found.reference, candidate, found.candidate)
    of_candidate = _Places(candidate, found.candidate, reference, found.reference)
    places_by = {name: of_candidate if name in OF_CANDIDATE else of_reference for name in results}
    return {
        name: figure.model_copy(update=places_by[name].at(figure.frames, figure.tracks))
        for name, figure in results.items()
    }


def confusion(
    reference: TrackTable, candidate: TrackTable, found: Matching, words: Mapping[int, str] | None = None
) -> Confusion:
    """Count boxes by reference label and candidate label; only labels that occur.

    Args:
        reference: one side.
        candidate: the other side.
        found: their matching.
        words: words of the labels from ``FIRST_UNKNOWN_LABEL`` down.
    """
    frame = np.concatenate(
        [reference.frame[found.reference], reference.frame[found.missed], candidate.frame[found.false]]
    )
    nothing = -2  # unlike -1, a sign of none of the classes
    reference_labels = np.concatenate(
        [reference.class_id[found.reference], reference.class_id[found.missed], np.full(len(found.false), nothing)]
    )
    candidate_labels = np.concatenate(
        [candidate.class_id[found.candidate], np.full(len(found.missed), nothing), candidate.class_id[found.false]]
    )
    names = [reference.names[t] for t in reference.track[np.concatenate([found.reference, found.missed])].tolist()]
    names += [candidate.names[t] for t in candidate.track[found.false].tolist()]
    index_of = {name: i for i, name in enumerate(dict.fromkeys(names))}
    track = np.array([index_of[name] for name in names], dtype=np.int64)
    keys = list(index_of)
    of_reference = _Places(reference, found.reference, candidate, found.candidate)
    of_candidate = _Places(candidate, found.candidate, reference, found.reference)
    cells = []
    for a, b in sorted({*zip(reference_labels.tolist(), candidate_labels.tolist(), strict=True)}):
        rows = np.flatnonzero((reference_labels == a) & (candidate_labels == b))
        places = _join_frames(frame[rows], track[rows], keys)[:MAX_PLACES]
        firsts, tracks = [p[0] for p in places], [p[2] for p in places]
        cells.append(
            Cell(
                reference=None if a == nothing else a,
                candidate=None if b == nothing else b,
                count=len(rows),
                frames=firsts,
                lasts=[p[1] for p in places],
                tracks=tracks,
                **(of_candidate if a == nothing else of_reference).at(firsts, tracks),
            )
        )
    classes = {int(c) for c in np.concatenate([reference_labels, candidate_labels]) if c != nothing}
    reported = {c: word for c, word in (words or {}).items() if c in classes}
    return Confusion(classes=sorted(classes, key=lambda c: (c < 0, abs(c))), words=reported, cells=cells)


_Place = tuple[int, int, str]


class _Places:
    """Finds the other side's boxes at the places of one side's tracks."""

    def __init__(self, own: TrackTable, rows: IntColumn, other: TrackTable, partners: IntColumn) -> None:
        self._pairs = PairFinder(own, other)
        self._number = {key: i for i, key in enumerate(own.names)}
        codes = own.frame[rows] * len(own.names) + own.track[rows]
        order = np.argsort(codes, kind="stable")
        self._codes, self._tracks, self._keys = codes[order], other.track[partners][order], other.names

    def at(self, frames: list[int], tracks: list[str]) -> JsonObject:
        """The fields ``partners`` and ``pairs`` of places, one per frame and key of this side."""
        partners = self._partners(frames, tracks)
        return {"partners": partners, "pairs": self._pairs.at(frames, tracks, partners)}

    def _partners(self, frames: list[int], tracks: list[str]) -> list[str | None]:
        """Keys of the other side, None where it has no match."""
        wanted = [f * len(self._number) + self._number[k] for f, k in zip(frames, tracks, strict=True)]
        places = np.searchsorted(self._codes, np.array(wanted, np.int64)).tolist()
        return [
            self._keys[self._tracks[i]] if i < len(self._codes) and self._codes[i] == code else None
            for i, code in zip(places, wanted, strict=True)
        ]


def _signs(reference: TrackTable, candidate: TrackTable, found: Matching) -> list[_Sign]:
    wide = ~reference.ignore & (reference.boxes[:, 2] - reference.boxes[:, 0] >= MIN_WIDTH)
    partner = np.full(len(reference), -1)
    partner[found.reference] = found.candidate
    order = np.argsort(reference.track, kind="stable")
    bounds = np.searchsorted(reference.track[order], np.arange(len(reference.names) + 1))
    signs = []
    for i, key in enumerate(reference.names):
        rows = order[bounds[i] : bounds[i + 1]]
        counted = rows[wide[rows]]
        if not len(counted):
            continue
        matched_rows = rows[partner[rows] >= 0]
        labels = reference.class_id[counted]
        values, counts = np.unique(labels, return_counts=True)
        most_frequent = values[counts == counts.max()]
        # Among equally frequent labels the first seen wins, as in Counter.most_common.
        label = next(int(c) for c in labels.tolist() if c in most_frequent)
        last = int(candidate.class_id[partner[matched_rows[-1]]]) if len(matched_rows) else None
        signs.append(
            _Sign(
                key=key,
                frames=reference.frame[counted],
                covered=reference.frame[counted[partner[counted] >= 0]],
                matched=reference.frame[matched_rows],
                tracks=candidate.track[partner[matched_rows]],
                right=last == label,
            )
        )
    return signs


def _interruptions(signs: list[_Sign]) -> list[tuple[int, str]]:
    """Frames where a sign's coverage was interrupted and resumed later."""
    found = []
    for sign in signs:
        places = np.searchsorted(sign.frames, sign.covered)
        for a, b in pairwise(places.tolist()):
            if b > a + 1:
                found.append((int(sign.frames[a + 1]), sign.key))
    return found


def _uncovered(signs: list[_Sign]) -> list[_Place]:
    found: list[_Place] = []
    for sign in signs:
        missing = np.setdiff1d(sign.frames, sign.covered, assume_unique=True)
        found += _join_frames(missing, np.zeros(len(missing), np.int64), [sign.key])
    return sorted(found)


def _false_tracks(candidate: TrackTable, found: Matching, matched_tracks: set[int]) -> list[tuple[int, str]]:
    """Tracks without a match whose rows are all false: one excused row excuses its track."""
    counts = np.bincount(candidate.track, minlength=len(candidate.names))
    false_counts = np.bincount(candidate.track[found.false], minlength=len(candidate.names))
    first_frames: dict[int, int] = {}
    for row in found.false.tolist():
        first_frames.setdefault(int(candidate.track[row]), int(candidate.frame[row]))
    return [
        (frame, candidate.names[track])
        for track, frame in first_frames.items()
        if track not in matched_tracks and false_counts[track] == counts[track]
    ]


def _mean_error(reference: TrackTable, found: Matching) -> Figure:
    """Mean of Eq. 7 over the matches; the places are the inexact matches, worst first."""
    differing = np.flatnonzero(found.error > ERROR_TOLERANCE)
    worst = differing[np.argsort(-found.error[differing], kind="stable")[:MAX_PLACES]]
    rows = found.reference[worst]
    places = [
        (f, f, reference.names[t])
        for f, t in zip(reference.frame[rows].tolist(), reference.track[rows].tolist(), strict=True)
    ]
    value = float(found.error.mean()) if len(found.error) else None
    figure = _figure(value, None, places, len(differing))
    return figure.model_copy(update={"errors": found.error[worst].tolist()})


def _frame_ranges(table: TrackTable, rows: IntColumn) -> list[_Place]:
    return _join_frames(table.frame[rows], table.track[rows], table.names)


def _join_frames(frame: IntColumn, track: IntColumn, keys: tuple[str, ...] | list[str]) -> list[_Place]:
    """Join consecutive frames of one track, ordered by first frame."""
    if not len(frame):
        return []
    order = np.lexsort((frame, track))
    f, t = frame[order], track[order]
    starts = np.concatenate([[0], np.flatnonzero((np.diff(t) != 0) | (np.diff(f) != 1)) + 1])
    ends = np.append(starts[1:], len(f)) - 1
    return sorted(zip(f[starts].tolist(), f[ends].tolist(), [keys[i] for i in t[starts].tolist()], strict=True))


def _share(part: int, whole: int, places: list[_Place]) -> Figure:
    return _figure(part / whole if whole else None, (part, whole), places)


def _count(places: list[tuple[int, str]]) -> Figure:
    return _figure(float(len(places)), None, sorted((f, f, k) for f, k in places))


def _figure(value: float | None, of: tuple[int, int] | None, places: list[_Place], total: int | None = None) -> Figure:
    cut = places[:MAX_PLACES]
    return Figure(
        value=value,
        of=of,
        frames=[p[0] for p in cut],
        lasts=[p[1] for p in cut],
        tracks=[p[2] for p in cut],
        partners=[None] * len(cut),
        places=len(places) if total is None else total,
    )
