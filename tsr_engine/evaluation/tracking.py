"""How well signs were tracked: Eq. 7, coverage, identities, and counts by physical sign (Tables I, II)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from tsr_engine.evaluation.tracking_rows import GroundTruth, Results, in_view
from tsr_engine.geometry.boxes import area, intersection, iou, non_overlap

BINS = 20
"""Bins of the histogram of Eq. 7 over [0, 1]."""


@dataclass(frozen=True, slots=True)
class SignReport:
    """One physical sign of one video."""

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

    def as_dict(self) -> dict[str, Any]:
        """The figures as values that JSON can hold."""
        return asdict(self)


def evaluate_video(
    name: str,
    truth: GroundTruth,
    results: Results,
    frames: int,
    min_width: float = 20.0,
    match_iou: float = 0.5,
    size: tuple[int, int] | None = None,
) -> VideoReport:
    """Compares one video's rows with its truth.

    In each frame results are assigned to counted truth with the largest total IoU; a sign keeps the id that it had
    in its last matched frame while that still overlaps enough (as in CLEAR MOT). What is left over is excused where
    an ignored box explains it: IoU, or intersection over the result's own area, of at least ``match_iou``.

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
        truth, results = in_view(truth, results, *size)
    held: dict[int, int] = {}
    matches: list[tuple[int, int]] = []
    excused = np.zeros(len(results.frame), dtype=bool)
    for frame in np.unique(results.frame):
        rows = np.flatnonzero(results.frame == frame)
        counted = np.flatnonzero((truth.frame == frame) & ~truth.ignore)
        ignored = np.flatnonzero((truth.frame == frame) & truth.ignore)
        for t, r in _match_frame(truth, results, counted, rows, held, match_iou):
            matches.append((t, r))
            held[int(truth.track_id[t])] = int(results.track_id[r])
        if len(ignored):
            boxes, cover = results.boxes[rows], truth.boxes[ignored]
            own = intersection(boxes, cover) / np.maximum(np.reshape(area(boxes), (-1, 1)), 1e-9)
            excused[rows] = (np.maximum(iou(boxes, cover), own) >= match_iou).any(axis=1)
    matched_rows = np.zeros(len(results.frame), dtype=bool)
    matched_rows[[r for _, r in matches]] = True
    justified = matched_rows | excused
    ids = {int(i) for i in results.track_id}
    good = {int(i) for i in results.track_id[justified]}
    widths = truth.boxes[:, 2] - truth.boxes[:, 0]
    wanted = ~truth.ignore & (widths >= min_width)
    found = [(t, r, float(non_overlap(truth.boxes[t], results.boxes[r])[0, 0])) for t, r in matches]
    wide = [match for match in found if wanted[match[0]]]
    signs = tuple(
        _sign_report(int(sign), truth, results, matches, wanted) for sign in np.unique(truth.track_id[wanted])
    )
    return VideoReport(
        name,
        frames,
        signs,
        tuple((error, results.source[r]) for _, r, error in wide),
        _followed(truth, results, matches, wanted),
        len(ids),
        tuple(sorted(ids - good)),
        int((~justified).sum()),
        tuple((int(truth.frame[t]), int(truth.track_id[t])) for t, *_ in wide),
        tuple(error for t, _, error in found if not wanted[t]),
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


def shared_errors(ours: Iterable[VideoReport], theirs: Iterable[VideoReport]) -> dict[str, Any]:
    """Mean Eq. 7 of two trackers over the signs and frames that both of them have.

    A mean over whatever a tracker returns gets better by leaving out what is hard; this one does not.

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


def changed_errors(ours: Iterable[VideoReport], theirs: Iterable[VideoReport]) -> dict[str, Any]:
    """Eq. 7 of two configurations over the signs and frames alone in which they differ.

    A part of the engine that acts in few frames hardly moves a mean over all of them; this tells what it did there.

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


def _match_frame(
    truth: GroundTruth, results: Results, counted: Any, rows: Any, held: dict[int, int], match_iou: float
) -> list[tuple[int, int]]:
    """(truth row, result row) of one frame; pairs of the last frame are kept while they overlap enough."""
    if not len(counted) or not len(rows):
        return []
    overlap = iou(truth.boxes[counted], results.boxes[rows])
    # A kept pair outweighs any number of new ones.
    gain = np.where(overlap >= match_iou, overlap, 0.0)
    for i, t in enumerate(counted):
        for j, r in enumerate(rows):
            if gain[i, j] > 0 and held.get(int(truth.track_id[t])) == int(results.track_id[r]):
                gain[i, j] += 10.0
    pairs = zip(*linear_sum_assignment(-gain), strict=True)
    return [(int(counted[i]), int(rows[j])) for i, j in pairs if gain[i, j] > 0]


def _sign_report(
    sign: int, truth: GroundTruth, results: Results, matches: list[tuple[int, int]], wanted: Any
) -> SignReport:
    own = sorted(((t, r) for t, r in matches if truth.track_id[t] == sign), key=lambda pair: int(truth.frame[pair[0]]))
    sequence = [int(results.track_id[r]) for _, r in own]
    mine = np.flatnonzero(wanted & (truth.track_id == sign))
    mine = mine[np.argsort(truth.frame[mine], kind="stable")]
    hit = {t for t, _ in own}
    covered = [int(t) in hit for t in mine]
    # Interruptions: covered again after a gap.
    seen = [i for i, c in enumerate(covered) if c]
    fragments = sum(1 for a, b in pairwise(seen) if b > a + 1)
    return SignReport(
        track_id=sign,
        class_id=Counter(int(c) for c in truth.class_id[mine]).most_common(1)[0][0],
        frames=len(mine),
        covered=sum(covered),
        ids=tuple(dict.fromkeys(sequence)),
        switches=sum(1 for a, b in pairwise(sequence) if a != b),
        fragments=fragments,
        predicted_class=int(results.class_id[own[-1][1]]) if own else None,
    )


def _followed(truth: GroundTruth, results: Results, matches: list[tuple[int, int]], wanted: Any) -> tuple[float, ...]:
    """Eq. 7 of each row against the sign that its track matched most often, in the frames where that is wanted."""
    votes: dict[int, Counter[int]] = {}
    for t, r in matches:
        votes.setdefault(int(results.track_id[r]), Counter())[int(truth.track_id[t])] += 1
    belongs = {track: counter.most_common(1)[0][0] for track, counter in votes.items()}
    place = {(int(truth.frame[t]), int(truth.track_id[t])): int(t) for t in np.flatnonzero(wanted)}
    errors = []
    for r in range(len(results.frame)):
        key = (int(results.frame[r]), belongs.get(int(results.track_id[r]), -1))
        if key in place:
            errors.append(float(non_overlap(truth.boxes[place[key]], results.boxes[r])[0, 0]))
    return tuple(errors)


def _share(part: float, whole: float) -> float | None:
    return part / whole if whole else None
