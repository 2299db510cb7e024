"""Evaluates tracking: Eq. 7, coverage, identities, and counts by physical sign (Tables I, II)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from itertools import pairwise

import numpy as np

from tsr_engine.evaluation.matching import Matching, match
from tsr_engine.geometry.boxes import non_overlap_each
from tsr_engine.json_shapes import JsonObject
from tsr_engine.track_table import BoolArray, TrackTable

BINS = 20
"""Bins of the histogram of Eq. 7 over [0, 1]."""


@dataclass(frozen=True, slots=True)
class SignReport:
    """The figures of one physical sign of one video."""

    track_id: int
    class_id: int
    frames: int
    """Counted frames of at least ``min_width`` px."""
    covered: int
    """... of which some track has IoU >= ``match_iou``."""
    ids: tuple[int, ...]
    """Track ids that matched it, in order of appearance."""
    switches: int
    """Changes of the matching id."""
    fragments: int
    """Interruptions of its coverage."""
    predicted_class: int | None
    """Fused class in its last matched frame; None if it was never matched."""


@dataclass(frozen=True, slots=True)
class VideoReport:
    """One video."""

    name: str
    frames: int
    signs: tuple[SignReport, ...]
    """Signs with a counted frame of at least ``min_width`` px."""
    errors: tuple[tuple[float, str], ...]
    """Eq. 7 and source of each matched row on a sign of at least ``min_width`` px: the frames that are covered."""
    followed_errors: tuple[float, ...]
    """Eq. 7 of every row of a sign's tracks against that sign of at least ``min_width`` px, also where they drifted."""
    tracks: int
    false_tracks: tuple[int, ...]
    """Ids of tracks that never match a counted nor an ignored sign."""
    false_rows: int
    """Rows that match neither."""
    matched: tuple[tuple[int, int], ...] = ()
    """Frame and sign of each of ``errors``."""
    narrow_errors: tuple[float, ...] = ()
    """Eq. 7 of each matched row on a narrower sign."""


@dataclass(frozen=True, slots=True)
class TrackingSummary:
    """Figures over one or more videos. Rates are in [0, 1]; NaN-free: a rate over nothing is None."""

    videos: int
    frames: int
    signs: int
    """Physical signs (Table I)."""
    signs_detected: int
    detection_rate: float | None
    """``signs_detected / signs``."""
    false_tracks: int
    """False detections in the sense of Table I: tracks on no sign."""
    false_positives_per_frame: float | None
    coverage: float | None
    """Share of truth frames of signs of at least ``min_width`` px with IoU >= ``match_iou``."""
    ids_per_sign: float | None
    """Mean number of ids over the detected signs."""
    switches: int
    fragments: int
    mean_error: float | None
    """Mean of Eq. 7 over the covered frames, those that ``coverage`` is the share of."""
    mean_error_overall: float | None
    """The same over all frames that ``coverage`` looks at, 1 where a sign is not covered: nothing is left out."""
    mean_error_any_width: float | None
    """Mean of Eq. 7 over all matched rows, those on signs narrower than ``min_width`` px too."""
    median_error: float | None
    mean_error_by_source: dict[str, float]
    mean_error_followed: float | None
    """Mean of Eq. 7 over all rows of the signs' tracks, matched or not."""
    histogram: tuple[int, ...]
    """Covered frames by Eq. 7, ``BINS`` equal bins over [0, 1]."""
    signs_classified: int
    """Detected signs whose fused class is right (Table II)."""
    classified_of_detected: float | None
    classified_of_all: float | None

    def as_dict(self) -> JsonObject:
        """The figures as values that JSON can hold."""
        return asdict(self)


def evaluate_video(
    name: str,
    truth: TrackTable,
    results: TrackTable,
    frames: int,
    min_width: float = 20.0,
    match_iou: float = 0.5,
    size: tuple[int, int] | None = None,
) -> VideoReport:
    """Compares one video's rows with its truth, matched by the rule of :mod:`~.matching`.

    Args:
        name: of the video, for the report.
        truth: annotated rows.
        results: tracked rows.
        frames: number of frames of the video.
        min_width: narrowest sign that coverage, Eq. 7 and detection count, px.
        match_iou: least IoU of a match.
        size: width and height of the picture, px, to which both are cut; unset: they are compared as they are.
    """
    if size is not None:
        truth, results = truth.cut(*size), results.cut(*size)
    truth, results = (table.rows(np.argsort(table.frame, kind="stable")) for table in (truth, results))
    found = match(truth, results, match_iou)
    wanted = ~truth.ignore & (truth.boxes[:, 2] - truth.boxes[:, 0] >= min_width)
    wide = wanted[found.reference]
    ids = np.unique(results.track)
    false = np.setdiff1d(ids, np.delete(results.track, found.false))
    words = results.source_words()
    rows = found.reference[wide]
    return VideoReport(
        name,
        frames,
        tuple(_sign_report(sign, truth, results, found, wanted) for sign in np.unique(truth.track[wanted]).tolist()),
        tuple(zip(found.error[wide].tolist(), (words[r] for r in found.candidate[wide].tolist()), strict=True)),
        _followed(truth, results, found, wanted),
        len(ids),
        tuple(false.tolist()),
        len(found.false),
        tuple(zip(truth.frame[rows].tolist(), truth.track[rows].tolist(), strict=True)),
        tuple(found.error[~wide].tolist()),
    )


def summarise(reports: Iterable[VideoReport]) -> TrackingSummary:
    """Figures over all videos together."""
    videos = list(reports)
    signs = [sign for video in videos for sign in video.signs]
    found = [sign for sign in signs if sign.ids]
    right = [sign for sign in found if sign.predicted_class == sign.class_id]
    errors = np.array([e for video in videos for e, _ in video.errors])
    narrow = [e for video in videos for e in video.narrow_errors]
    wanted, covered = sum(sign.frames for sign in signs), sum(sign.covered for sign in signs)
    followed = [e for video in videos for e in video.followed_errors]
    by_source: dict[str, list[float]] = {}
    for video in videos:
        for error, source in video.errors:
            by_source.setdefault(source, []).append(error)
    frames = sum(video.frames for video in videos)
    return TrackingSummary(
        videos=len(videos),
        frames=frames,
        signs=len(signs),
        signs_detected=len(found),
        detection_rate=_share(len(found), len(signs)),
        false_tracks=sum(len(video.false_tracks) for video in videos),
        false_positives_per_frame=_share(sum(video.false_rows for video in videos), frames),
        coverage=_share(covered, wanted),
        ids_per_sign=_share(sum(len(sign.ids) for sign in found), len(found)),
        switches=sum(sign.switches for sign in signs),
        fragments=sum(sign.fragments for sign in signs),
        mean_error=float(errors.mean()) if len(errors) else None,
        mean_error_overall=_share(float(errors.sum()) + wanted - covered, wanted),
        mean_error_any_width=_share(float(errors.sum()) + sum(narrow), len(errors) + len(narrow)),
        median_error=float(np.median(errors)) if len(errors) else None,
        mean_error_by_source={source: float(np.mean(values)) for source, values in sorted(by_source.items())},
        mean_error_followed=float(np.mean(followed)) if followed else None,
        histogram=tuple(int(n) for n in np.histogram(errors, bins=BINS, range=(0.0, 1.0))[0]),
        signs_classified=len(right),
        classified_of_detected=_share(len(right), len(found)),
        classified_of_all=_share(len(right), len(signs)),
    )


def _by_place(report: VideoReport) -> dict[tuple[int, int], float]:
    """Frame and sign -> Eq. 7 of its match."""
    return dict(zip(report.matched, (error for error, _ in report.errors), strict=True))


def shared_errors(ours: Iterable[VideoReport], theirs: Iterable[VideoReport]) -> JsonObject:
    """Mean Eq. 7 of two trackers over the signs and frames that both of them have.

    A mean over all results of a tracker improves if it leaves out hard signs; this mean does not.

    Args:
        ours: reports of one tracker.
        theirs: of the other one, on the same videos in the same order.

    Returns:
        ``n`` signs and frames in common, ``ours`` and ``theirs`` (None without any).
    """
    pairs = []
    for a, b in zip(ours, theirs, strict=True):
        known = _by_place(a)
        pairs += [(known[place], error) for place, error in _by_place(b).items() if place in known]
    mine, other = np.mean(pairs, axis=0).tolist() if pairs else (None, None)
    return {"n": len(pairs), "ours": mine, "theirs": other}


def changed_errors(ours: Iterable[VideoReport], theirs: Iterable[VideoReport]) -> JsonObject:
    """Eq. 7 of two configurations over the signs and frames alone in which they differ.

    A part of the engine that acts in few frames hardly changes a mean over all frames; this one shows its effect.

    Args:
        ours: reports of one configuration.
        theirs: of the other one, on the same videos in the same order.

    Returns:
        ``n`` signs and frames that both have and in which Eq. 7 differs, ``ours`` and ``theirs`` there (None without
        any); ``only_ours`` and ``only_theirs``: signs and frames that one of them alone has.
    """
    pairs, only_ours, only_theirs = [], 0, 0
    for a, b in zip(ours, theirs, strict=True):
        mine, other = _by_place(a), _by_place(b)
        pairs += [(mine[place], other[place]) for place in mine.keys() & other if mine[place] != other[place]]
        only_ours += len(mine.keys() - other)
        only_theirs += len(other.keys() - mine)
    means = np.mean(sorted(pairs), axis=0).tolist() if pairs else (None, None)
    return {"n": len(pairs), "ours": means[0], "theirs": means[1], "only_ours": only_ours, "only_theirs": only_theirs}


def _sign_report(sign: int, truth: TrackTable, results: TrackTable, found: Matching, wanted: BoolArray) -> SignReport:
    own = truth.track[found.reference] == sign
    matched = found.candidate[own]
    sequence = results.track[matched].tolist()
    mine = np.flatnonzero(wanted & (truth.track == sign))
    seen = np.flatnonzero(np.isin(mine, found.reference[own])).tolist()
    return SignReport(
        track_id=sign,
        class_id=Counter(truth.class_id[mine].tolist()).most_common(1)[0][0],
        frames=len(mine),
        covered=len(seen),
        ids=tuple(dict.fromkeys(sequence)),
        switches=sum(1 for a, b in pairwise(sequence) if a != b),
        # Interruptions: covered again after a gap.
        fragments=sum(1 for a, b in pairwise(seen) if b > a + 1),
        predicted_class=int(results.class_id[matched[-1]]) if len(matched) else None,
    )


def _followed(truth: TrackTable, results: TrackTable, found: Matching, wanted: BoolArray) -> tuple[float, ...]:
    """Eq. 7 of each row against the sign that its track matched most often, in the frames where that is wanted."""
    votes: dict[int, Counter[int]] = {}
    for sign, track in zip(truth.track[found.reference].tolist(), results.track[found.candidate].tolist(), strict=True):
        votes.setdefault(track, Counter())[sign] += 1
    belongs = {track: counter.most_common(1)[0][0] for track, counter in votes.items()}
    rows = np.flatnonzero(wanted)
    place = dict(zip(zip(truth.frame[rows].tolist(), truth.track[rows].tolist(), strict=True), rows, strict=True))
    keys = zip(results.frame.tolist(), (belongs.get(track) for track in results.track.tolist()), strict=True)
    pairs = [(place[key], row) for row, key in enumerate(keys) if key in place]
    a, b = np.array(pairs, np.int64).reshape(-1, 2).T
    return tuple(non_overlap_each(truth.boxes[a], results.boxes[b]).tolist())


def _share(part: float, whole: float) -> float | None:
    return part / whole if whole else None
