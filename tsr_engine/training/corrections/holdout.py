"""Holds out corrected frames from a refinement, and compares two versions on them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tsr_engine.detection.acf import AcfDetector, AcfModel
from tsr_engine.detection.prior import SpatialPrior
from tsr_engine.evaluation.detection import match, score_detections
from tsr_engine.geometry.boxes import covered_share, iou, non_overlap
from tsr_engine.io.pictures import read_picture
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params.detector import DetectorParams
from tsr_engine.protocols import CropClassifier
from tsr_engine.records import FloatArray
from tsr_engine.training.corrections.corrected_scenes import CorrectedScene
from tsr_engine.training.corrections.refine_classifier import SignCrop
from tsr_engine.training.progress import Progress
from tsr_engine.training.synthetic.classifier_augmentation import plain_view

__all__ = ["HoldoutSplit", "evaluate_detection", "evaluate_reading", "hold_out", "regressions", "right_shares"]


_MIN_CHANGE = 0.005
"""Shares that fall by no more than this are not called worse."""
_SHARES = {
    "ap50": "average precision at IoU 0.5",
    "ap75": "average precision at IoU 0.75",
    "recall_at_0.1": "recall at 0.1 false detections a picture",
    "crops_right": "share of crops read right",
    "signs_right": "share of signs read right",
    "signs_kept": "share of remembered signs that are detected",
    "others_kept": "share of remembered background that is refused",
    "crops_kept": "share of remembered crops read right",
}


@dataclass(frozen=True, slots=True)
class HoldoutSplit:
    """Corrected frames in two parts that share no sign and no rejected track.

    Attributes:
        training: frames to learn from; what is held out is ignored in them.
        held: frames for figures; what trains is ignored in them. Empty: too few signs to hold any out.
        by: ``video``, ``sign``, ``export`` (the split that the export came with) or ``none``.
        signs: names of the held-out signs.
    """

    training: list[CorrectedScene]
    held: list[CorrectedScene] = field(default_factory=list)
    by: str = "none"
    signs: frozenset[str] = frozenset()


def hold_out(
    scenes: Sequence[CorrectedScene],
    seed: int,
    share: float,
    given_split: Mapping[str, str] | None = None,
    learned: Collection[str] = (),
) -> HoldoutSplit:
    """Hold out a share of the corrected signs: whole videos where there are several, else single signs.

    Args:
        scenes: corrected frames.
        seed: decides which.
        share: of the videos or signs that are held out, at least one; 0: none.
        given_split: subset of each sign in an earlier split (``train``, ``val``, ``test``); what is not ``train`` is
            held out.
        learned: videos that the earlier version has learned from; others are held out if there are any.
    """
    if share <= 0:
        return HoldoutSplit(list(scenes))
    names = sorted({sign for scene in scenes for sign in scene.signs})
    rng = np.random.default_rng([seed, 51])
    outside_training = {name for name in names if given_split is not None and given_split.get(name, "train") != "train"}
    if outside_training and len(outside_training) < len(names):
        by, held = "export", frozenset(outside_training)
    else:
        by, held = _draw_held_out(scenes, names, rng, share, learned)
    if not held:
        return HoldoutSplit(list(scenes))
    rest = frozenset(names) - held
    # Of a video without another sign, frames that show none are held out too: their background has been seen otherwise.
    videos = {scene.video for scene in scenes if held & set(scene.signs)}
    videos -= {scene.video for scene in scenes if rest & set(scene.signs)}
    training = [s for s in scenes if s.video not in videos and (rest & set(s.signs) or not s.signs)]
    tested = [s for s in scenes if s.video in videos or held & set(s.signs)]
    rejected = frozenset(track for scene in scenes for track in scene.rejected_tracks)
    away = frozenset(track for s in tested if s.video in videos for track in s.rejected_tracks)
    # of a video with signs in both parts, as many rejected tracks are held out as signs
    parted = {scene.video for scene in tested} - videos
    shared = sorted({track for scene in scenes if scene.video in parted for track in scene.rejected_tracks})
    if by == "export" and given_split is not None:
        away |= {track for track in shared if given_split.get(track, "train") != "train"}
    else:
        away |= {str(track) for track in rng.permutation(shared)[: round(share * len(shared))]}
    training = [scene.without(held | away) for scene in training]
    return HoldoutSplit(training, [s.without(rest | (rejected - away)) for s in tested], by, held)


def _draw_held_out(
    scenes: Sequence[CorrectedScene],
    names: Sequence[str],
    rng: np.random.Generator,
    share: float,
    learned: Collection[str],
) -> tuple[str, frozenset[str]]:
    of_video: dict[str, set[str]] = {}
    for scene in scenes:
        if scene.signs:
            of_video.setdefault(scene.video, set()).update(scene.signs)
    videos = sorted(of_video)
    groups = videos if len(videos) > 1 else names
    if len(groups) < 2:
        return "none", frozenset()
    drawn = [str(name) for name in rng.permutation(list(groups))]
    if groups is videos:
        drawn = [name for name in drawn if name not in learned] or drawn
    drawn = drawn[: max(1, round(share * len(groups)))]
    if groups is videos:
        return "video", frozenset().union(*(of_video[name] for name in drawn))
    return "sign", frozenset(drawn)


def evaluate_detection(
    model: AcfModel, prior: SpatialPrior | None, scenes: Sequence[CorrectedScene], progress: Progress
) -> JsonObject:
    """AP, recall and mean Eq. 7 of a detector on corrected frames, tight boxes, with the prior.

    A detection on an ignored place counts neither way.
    """
    detector = AcfDetector(model, prior, DetectorParams(second_core=False, keep_score=-8.0))
    results, errors = [], []
    for done, scene in enumerate(scenes):
        progress("held-out frames", done, len(scenes))
        detections, truth = detector.detect(read_picture(scene.scene.path)), scene.scene.boxes
        is_counted = _is_counted(detections.boxes, truth, scene.scene.ignored)
        boxes, scores = detections.boxes[is_counted], detections.scores[is_counted]
        results.append((boxes, scores, truth))
        _, found = match(boxes, scores, truth)
        errors += [float(non_overlap(boxes[d], truth[s])[0, 0]) for s, d in enumerate(found) if d >= 0]
    coarse, fine = score_detections(results, 0.5), score_detections(results, 0.75)
    return {
        "ap50": round(coarse.average_precision, 4),
        "ap75": round(fine.average_precision, 4),
        "recall_at_0.1": round(coarse.recall_at(0.1), 4),
        "mean_eq7": round(float(np.mean(errors)), 4) if errors else None,
        "boxes": coarse.signs,
        "pictures": coarse.pictures,
    }


def _is_counted(boxes: FloatArray, truth: FloatArray, ignored: FloatArray) -> NDArray[np.bool_]:
    """Which detections count: those on a sign, and those on no ignored place."""
    is_ignored = covered_share(boxes, ignored) >= 0.5  # the IoU is never larger
    return np.asarray(~is_ignored | (iou(boxes, truth) >= 0.5).any(axis=1))


def evaluate_reading(classifier: CropClassifier, crops: Sequence[SignCrop]) -> JsonObject:
    """Share of crops, and of signs by the sum of their crops' probabilities, that are read right."""
    if not crops:
        return {}
    return right_shares(classifier.probabilities([plain_view(item.crop) for item in crops]), crops)


def right_shares(answers: NDArray[np.floating], crops: Sequence[SignCrop]) -> JsonObject:
    """As ``evaluate_reading``, for the class probabilities of the crops, shape (n, c)."""
    labels = np.array([item.crop.class_id for item in crops])
    votes: dict[str, FloatArray] = {}
    truth: dict[str, int] = {}
    for item, row in zip(crops, answers.astype(np.float64), strict=True):
        votes[item.sign] = votes.get(item.sign, np.zeros(len(row))) + row
        truth[item.sign] = item.crop.class_id
    correct = sum(int(vote.argmax()) == truth[sign] for sign, vote in votes.items())
    return {
        "crops_right": round(float((answers.argmax(axis=1) == labels).mean()), 4),
        "signs_right": round(correct / len(votes), 4),
        "crops": len(crops),
        "signs": len(votes),
    }


def regressions(new: JsonMapping, parent: JsonMapping, where: str) -> list[str]:
    """Sentences on what the new version does worse than the earlier one."""
    out = []
    for name, words in _SHARES.items():
        before, after = parent.get(name), new.get(name)
        if before is not None and after is not None and after < before - _MIN_CHANGE:
            out.append(f"{where}: {words} falls from {before:.3f} to {after:.3f}.")
    before, after = parent.get("mean_eq7"), new.get("mean_eq7")
    if before is not None and after is not None and after > before + _MIN_CHANGE:
        out.append(f"{where}: the mean of Eq. 7 rises from {before:.3f} to {after:.3f}.")
    return out
