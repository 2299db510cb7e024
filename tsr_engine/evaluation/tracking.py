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
"""Number of bins of the histogram of Eq. 7 over [0, 1]."""


@dataclass(frozen=True, slots=True)
class SignReport:
    """The figures of one physical sign of one video."""

    track_id: int
    class_id: int
    frames: int
    """Number of counted frames in which the sign is at least ``min_width`` px wide."""
    covered: int
    """Number of these frames in which a track matches with IoU >= 0.5."""
    ids: tuple[int, ...]
    """Ids of the tracks that matched the sign, in order of appearance."""
    switches: int
    """Number of changes of the matching id."""
    fragments: int
    """Number of interruptions of the coverage."""
    predicted_class: int | None
    """Fused class in its last matched frame; None if it was never matched."""


@dataclass(frozen=True, slots=True)
class VideoReport:
    """The figures of one video."""

    name: str
    frames: int
    signs: tuple[SignReport, ...]
    """Signs with a counted frame of at least ``min_width`` px."""
    errors: tuple[tuple[float, str], ...]
    """Eq. 7 and source of each matched row on a sign of at least ``min_width`` px: the covered frames."""
    followed_errors: tuple[float, ...]
    """Eq. 7 of every row of a sign's tracks against that sign of at least ``min_width`` px, with or without a match."""
    tracks: int
    false_tracks: tuple[int, ...]
    """Ids of tracks that match neither a counted nor an ignored sign in any frame."""
    false_rows: int
    """Number of rows that match neither."""
    matched: tuple[tuple[int, int], ...] = ()
    """Frame and sign of each of ``errors``."""
    narrow_errors: tuple[float, ...] = ()
    """Eq. 7 of each matched row on a narrower sign."""


@dataclass(frozen=True, slots=True)
class TrackingSummary:
    """Figures over one or more videos. Rates are in [0, 1]; a rate without data is None, never NaN."""

    videos: int
    frames: int
    signs: int
    """Number of physical signs (Table I)."""
    signs_detected: int
    detection_rate: float | None
    """``signs_detected / signs``."""
    false_tracks: int
    """Number of tracks on no sign, the false detections of Table I."""
    false_positives_per_frame: float | None
    coverage: float | None
    """Share of the annotated frames of signs of at least ``min_width`` px that have a match of IoU >= 0.5."""
    ids_per_sign: float | None
    """Mean number of ids over the detected signs."""
    switches: int
    fragments: int
    mean_error: float | None
    """Mean of Eq. 7 over the covered frames."""
    mean_error_overall: float | None
    """Mean of Eq. 7 over all annotated frames of signs of at least ``min_width`` px, 1 for frames without a match."""
    mean_error_any_width: float | None
    """Mean of Eq. 7 over all matched rows, including those on signs narrower than ``min_width`` px."""
    median_error: float | None
    mean_error_by_source: dict[str, float]
    mean_error_followed: float | None
    """Mean of Eq. 7 over all rows of the signs' tracks, matched or not."""
    histogram: tuple[int, ...]
    """Number of covered frames by Eq. 7, in ``BINS`` equal bins over [0, 1]."""
    signs_classified: int
    """Number of detected signs whose fused class is correct (Table II)."""
    classified_of_detected: float | None
    classified_of_all: float | None

    def as_dict(self) -> JsonObject:
        """The figures as values for JSON."""
        return asdict(self)


def evaluate_video(
    name: str,
    truth: TrackTable,
    results: TrackTable,
    frames: int,
    min_width: float = 20.0,
    size: tuple[int, int] | None = None,
) -> VideoReport:
    """Compare one video's rows with its ground truth, matched by :mod:`~.matching`.

    Args:
        name: name of the video, for the report.
        truth: annotated rows.
        results: tracked rows.
        frames: number of frames of the video.
        min_width: least width of signs for coverage, Eq. 7 and detection rate, px.
        size: width and height of the picture, px, to which all boxes are clipped; unset: no clipping.
    """
    if size is not None:
        truth, results = truth.cut(*size), results.cut(*size)
    truth, results = (table.rows(np.argsort(table.frame, kind="stable")) for table in (truth, results))
    matching = match(truth, results)
    is_counted = ~truth.ignore & (truth.boxes[:, 2] - truth.boxes[:, 0] >= min_width)
    is_wide = is_counted[matching.reference]
    ids = np.unique(results.track)
    false = np.setdiff1d(ids, np.delete(results.track, matching.false))
    sources = results.source_words()
    rows = matching.reference[is_wide]
    return VideoReport(
        name,
        frames,
        tuple(
            _sign_report(sign, truth, results, matching, is_counted)
            for sign in np.unique(truth.track[is_counted]).tolist()
        ),
        tuple(
            zip(
                matching.error[is_wide].tolist(),
                (sources[r] for r in matching.candidate[is_wide].tolist()),
                strict=True,
            )
        ),
        _followed_errors(truth, results, matching, is_counted),
        len(ids),
        tuple(false.tolist()),
        len(matching.false),
        tuple(zip(truth.frame[rows].tolist(), truth.track[rows].tolist(), strict=True)),
        tuple(matching.error[~is_wide].tolist()),
    )


def summarise(reports: Iterable[VideoReport]) -> TrackingSummary:
    """Combine the figures of all videos."""
    videos = list(reports)
    signs = [sign for video in videos for sign in video.signs]
    detected = [sign for sign in signs if sign.ids]
    classified = [sign for sign in detected if sign.predicted_class == sign.class_id]
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
        signs_detected=len(detected),
        detection_rate=_share(len(detected), len(signs)),
        false_tracks=sum(len(video.false_tracks) for video in videos),
        false_positives_per_frame=_share(sum(video.false_rows for video in videos), frames),
        coverage=_share(covered, wanted),
        ids_per_sign=_share(sum(len(sign.ids) for sign in detected), len(detected)),
        switches=sum(sign.switches for sign in signs),
        fragments=sum(sign.fragments for sign in signs),
        mean_error=float(errors.mean()) if len(errors) else None,
        mean_error_overall=_share(float(errors.sum()) + wanted - covered, wanted),
        mean_error_any_width=_share(float(errors.sum()) + sum(narrow), len(errors) + len(narrow)),
        median_error=float(np.median(errors)) if len(errors) else None,
        mean_error_by_source={source: float(np.mean(values)) for source, values in sorted(by_source.items())},
        mean_error_followed=float(np.mean(followed)) if followed else None,
        histogram=tuple(int(n) for n in np.histogram(errors, bins=BINS, range=(0.0, 1.0))[0]),
        signs_classified=len(classified),
        classified_of_detected=_share(len(classified), len(detected)),
        classified_of_all=_share(len(classified), len(signs)),
    )


def _errors_by_frame_and_sign(report: VideoReport) -> dict[tuple[int, int], float]:
    """Frame and sign -> Eq. 7 of the match."""
    return dict(zip(report.matched, (error for error, _ in report.errors), strict=True))


def shared_errors(ours: Iterable[VideoReport], theirs: Iterable[VideoReport]) -> JsonObject:
    """Mean Eq. 7 of two trackers on the same videos, over the pairs of sign and frame that both cover.

    A tracker can improve the mean over all of its results by leaving out hard signs, but not this mean.

    Returns:
        ``n``: number of common pairs; ``ours`` and ``theirs``: the means, None without common pairs.
    """
    pairs = []
    for a, b in zip(ours, theirs, strict=True):
        our_errors = _errors_by_frame_and_sign(a)
        pairs += [
            (our_errors[place], error) for place, error in _errors_by_frame_and_sign(b).items() if place in our_errors
        ]
    our_mean, their_mean = np.mean(pairs, axis=0).tolist() if pairs else (None, None)
    return {"n": len(pairs), "ours": our_mean, "theirs": their_mean}


def changed_errors(ours: Iterable[VideoReport], theirs: Iterable[VideoReport]) -> JsonObject:
    """Mean Eq. 7 of two configurations on the same videos, over the pairs of sign and frame in which they differ.

    A part of the engine that acts in few frames hardly changes a mean over all frames; this mean shows its effect.

    Returns:
        ``n``: number of pairs that both cover with different Eq. 7; ``ours`` and ``theirs``: the means over them, None
        without such pairs; ``only_ours`` and ``only_theirs``: numbers of pairs that only one of them covers.
    """
    pairs, only_ours, only_theirs = [], 0, 0
    for a, b in zip(ours, theirs, strict=True):
        our_errors, their_errors = _errors_by_frame_and_sign(a), _errors_by_frame_and_sign(b)
        pairs += [
            (our_errors[place], their_errors[place])
            for place in our_errors.keys() & their_errors
            if our_errors[place] != their_errors[place]
        ]
        only_ours += len(our_errors.keys() - their_errors)
        only_theirs += len(their_errors.keys() - our_errors)
    means = np.mean(sorted(pairs), axis=0).tolist() if pairs else (None, None)
    return {"n": len(pairs), "ours": means[0], "theirs": means[1], "only_ours": only_ours, "only_theirs": only_theirs}


def _sign_report(
    sign: int, truth: TrackTable, results: TrackTable, matching: Matching, is_counted: BoolArray
) -> SignReport:
    is_of_sign = truth.track[matching.reference] == sign
    matched = matching.candidate[is_of_sign]
    sequence = results.track[matched].tolist()
    sign_rows = np.flatnonzero(is_counted & (truth.track == sign))
    covered = np.flatnonzero(np.isin(sign_rows, matching.reference[is_of_sign])).tolist()
    return SignReport(
        track_id=sign,
        class_id=Counter(truth.class_id[sign_rows].tolist()).most_common(1)[0][0],
        frames=len(sign_rows),
        covered=len(covered),
        ids=tuple(dict.fromkeys(sequence)),
        switches=sum(1 for a, b in pairwise(sequence) if a != b),
        # An interruption is a gap between two covered frames.
        fragments=sum(1 for a, b in pairwise(covered) if b > a + 1),
        predicted_class=int(results.class_id[matched[-1]]) if len(matched) else None,
    )


def _followed_errors(
    truth: TrackTable, results: TrackTable, matching: Matching, is_counted: BoolArray
) -> tuple[float, ...]:
    """Eq. 7 of each row against the sign that its track matched most often, in the wanted frames of that sign."""
    votes: dict[int, Counter[int]] = {}
    for sign, track in zip(
        truth.track[matching.reference].tolist(), results.track[matching.candidate].tolist(), strict=True
    ):
        votes.setdefault(track, Counter())[sign] += 1
    sign_of_track = {track: counter.most_common(1)[0][0] for track, counter in votes.items()}
    rows = np.flatnonzero(is_counted)
    row_of = dict(zip(zip(truth.frame[rows].tolist(), truth.track[rows].tolist(), strict=True), rows, strict=True))
    keys = zip(results.frame.tolist(), (sign_of_track.get(track) for track in results.track.tolist()), strict=True)
    pairs = [(row_of[key], row) for row, key in enumerate(keys) if key in row_of]
    a, b = np.array(pairs, np.int64).reshape(-1, 2).T
    return tuple(non_overlap_each(truth.boxes[a], results.boxes[b]).tolist())


def _share(part: float, whole: float) -> float | None:
    return part / whole if whole else None
