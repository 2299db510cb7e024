"""Follows a sign in one direction, frame by frame away from an anchor.

Each frame predicts the box from the sign's path and the camera's shift, searches for the known templates, lets the
detector's later stages set the edges of known shapes, and computes the confidence.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from tsr_engine.follow.confidence import MIN_KEPT_CONFIDENCE, MIN_LEARNED_CONFIDENCE, Evidence
from tsr_engine.follow.known_shape import KnownShape, match_known_shape
from tsr_engine.follow.picture_pixels import PicturePixels
from tsr_engine.follow.records import Direction, FollowerModels, Source
from tsr_engine.follow.search import Match, search
from tsr_engine.follow.sign_path import SignPath
from tsr_engine.follow.template import Template, size_of
from tsr_engine.geometry.boxes import area, clip, iou_each, to_cxcywh
from tsr_engine.online.features import describe
from tsr_engine.online.online_detector import OnlineDetector, is_describable
from tsr_engine.records import FloatArray, Picture

_MAX_TEMPLATES: Final = 14
"""Largest number of templates."""
_TEMPLATES_PER_FRAME: Final = 3
"""Number of templates to compare in each frame: those of the most similar size, including one of an anchor."""
_MIN_LOG_SIZE_DIFFERENCE: Final = math.log(1.2)
"""Least difference in size, natural logarithm, between a new template and all others."""
_LIKELY_SIMILARITY: Final = 0.5
"""Similarity below which the expected place is scored, not the match; the match then counts only if it lies there."""
_SAME_PLACE_IOU: Final = 0.5
"""IoU with the scored place from which a match lies there."""
_UNSURE_SIMILARITY: Final = 0.7
"""Similarity below which the search is repeated in a larger area."""
_MIN_SIMILARITY_GAIN: Final = 0.1
"""Least gain in similarity for the result of the larger search to count."""
_WIDE_SEARCH_SPREAD: Final = 0.16
"""Least range of sizes of the larger search, natural logarithm."""
_MIN_LEARN_VISIBLE_SHARE: Final = 0.98
"""Visible share from which a template is learned."""


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One frame's result.

    Attributes:
        box: shape (4,), px; may reach beyond the picture.
        confidence: see :class:`tsr_engine.follow.records.Proposal`.
        source: source of the box.
        place_error: standard deviation of the centre, px.
        size_error: standard deviation of the natural logarithm of the size.
        evidence: observations behind the confidence; None if there are none.
    """

    box: FloatArray
    confidence: float
    source: Source
    place_error: float
    size_error: float
    evidence: Evidence | None

    def within(self, error: float) -> Step:
        """The step with errors that include an error of the first box, as a share of its size."""
        place = math.hypot(self.place_error, error * size_of(self.box))
        return replace(self, place_error=place, size_error=math.hypot(self.size_error, error))


class SignFollower:
    """Follows one sign from an anchor in one direction.

    Args:
        picture: picture of the anchor's frame.
        box: the anchor's box, shape (4,), px.
        templates: templates of all anchors.
        direction: direction of time.
        parts: the trained parts.

    Attributes:
        hidden: number of frames since the sign was seen; 0: it is seen.
    """

    def __init__(
        self, picture: Picture, box: FloatArray, templates: list[Template], direction: Direction, parts: FollowerModels
    ) -> None:
        self.hidden = 0
        self._size = (picture.shape[1], picture.shape[0])
        self._path = SignPath(box, self._size, direction)
        self._templates = list(templates)
        self._stretch = math.sqrt((box[2] - box[0]) / (box[3] - box[1]))
        self._shape: KnownShape | None = match_known_shape(parts.window_scorer, picture, box)
        self._online: OnlineDetector | None = None
        if parts.make_online is not None and is_describable(box):
            self._online = parts.make_online(PicturePixels(picture), box, 0)[0]
        self._frames = 0
        self._frames_since_update = 0
        self._last = Step(box, 1.0, "matched", self._path.place_error, self._path.size_error, None)

    def step(self, picture: Picture, shift: tuple[float, float], repeated: bool = False, learn: bool = True) -> Step:
        """Process the next frame.

        Args:
            picture: BGR, uint8, of the same size as the anchor's.
            shift: shift by camera rotation since the last frame, px.
            repeated: whether the picture repeats the last one.
            learn: whether the sign's appearance in this picture may be learned.
        """
        self._frames += 1
        self._frames_since_update += 1
        if repeated:
            return self._last
        self._path.predict(float(self._frames_since_update), shift)
        self._frames_since_update = 0
        self._last = self._follow_in(picture, learn)
        return self._last

    def _follow_in(self, picture: Picture, learn: bool) -> Step:
        expected = self._path.box
        if not self._in_view(expected):
            return self._hide(expected, 0.0, None)
        match, place_error = self._match(picture, expected)
        place = expected if match is None or match.similarity < _LIKELY_SIMILARITY else match.box
        match_agrees = match is not None and float(iou_each(match.box, place)[0]) >= _SAME_PLACE_IOU
        detected = None if self._shape is None else self._shape.measure(picture, place)
        size = size_of(expected)
        evidence = Evidence(
            similarity=0.0 if match is None else match.similarity,
            anchor_similarity=0.0 if match is None else match.anchor_similarity,
            away=float(np.hypot(*(to_cxcywh(place) - to_cxcywh(expected))[:2])) / (place_error + 0.05 * size),
            grown=abs(math.log(size_of(place) / size)) / (self._path.size_error + 0.02),
            decision=self._decision(picture, place),
            score=None if detected is None else detected.score,
        )
        confidence = evidence.confidence
        measured = match_agrees or (detected is not None and detected.box is not None)
        if confidence < MIN_KEPT_CONFIDENCE or not measured:
            return self._hide(expected, confidence, evidence)
        self.hidden = 0
        if match is not None and match_agrees:
            self._path.correct(match.box, math.sqrt(match.variance))
        if detected is not None and detected.box is not None:
            self._path.correct(detected.box, detected.error)
        box = self._path.box
        if learn and confidence >= MIN_LEARNED_CONFIDENCE:
            self._learn(picture, box)
        source: Source = "detected" if detected is not None and detected.box is not None else "matched"
        return Step(box, confidence, source, self._path.place_error, self._path.size_error, evidence)

    def _hide(self, expected: FloatArray, confidence: float, evidence: Evidence | None) -> Step:
        self.hidden += 1
        return Step(expected, confidence, "predicted", self._path.place_error, self._path.size_error, evidence)

    def _match(self, picture: Picture, expected: FloatArray) -> tuple[Match | None, float]:
        """The best match near the expected box or in a larger area, and the error of place that the search allowed."""
        error, spread = self._path.place_error, min(3.0 * self._path.size_error, 0.3)
        max_radius = 1.2 * float(max(expected[2:] - expected[:2])) + 24.0
        radius = min(3.0 * error + 3.0, max_radius)
        templates = self._comparable(size_of(expected))
        match = search(picture, templates, expected, self._stretch, radius, spread)
        similarity = 0.0 if match is None else match.similarity
        # While a sign stays hidden, wide searches become rarer, to save time.
        is_due = self.hidden & (self.hidden - 1) == 0
        if radius < 0.7 * max_radius and similarity < _UNSURE_SIMILARITY and is_due:
            wide = search(picture, templates, expected, self._stretch, max_radius, max(spread, _WIDE_SEARCH_SPREAD))
            if wide is not None and wide.similarity > max(similarity + _MIN_SIMILARITY_GAIN, _UNSURE_SIMILARITY):
                return wide, max_radius / 3.0
        return match, error

    def _comparable(self, size: float) -> list[Template]:
        """The templates to compare for a size, the nearest first."""
        ranked = sorted(self._templates, key=lambda template: abs(math.log(size / template.size)))
        chosen = ranked[:_TEMPLATES_PER_FRAME]
        if not any(template.anchor for template in chosen):
            chosen[-1] = next(template for template in ranked if template.anchor)
        return chosen

    def _decision(self, picture: Picture, box: FloatArray) -> float | None:
        if self._online is None or not is_describable(box) or not self._in_view(box):
            return None
        features = describe(PicturePixels(picture), box)
        return float(self._online.svm.decision_function(features[None])[0])

    def _learn(self, picture: Picture, box: FloatArray) -> None:
        """Learn the sign's appearance in a box if its size is new and the sign is wholly visible."""
        size = size_of(box)
        if min(abs(math.log(size / template.size)) for template in self._templates) < _MIN_LOG_SIZE_DIFFERENCE:
            return
        if visible_share(box, *self._size) < _MIN_LEARN_VISIBLE_SHARE:
            return
        self._templates.append(Template.cut(picture, box, max(self._path.size_error**2, 1e-5), False))
        if len(self._templates) > _MAX_TEMPLATES:
            self._templates.remove(next(template for template in self._templates if not template.anchor))
        if self._online is not None and is_describable(box):
            self._online.learn(PicturePixels(picture), box, 1, self._frames)

    def _in_view(self, box: FloatArray) -> bool:
        return visible_share(box, *self._size) > 0.0


def visible_share(box: FloatArray, width: int, height: int) -> float:
    """The share of a box's area, shape (4,), that lies in a picture of width x height px."""
    total = float(area(box))
    return float(area(clip(box, width, height))) / total if total > 0.0 else 0.0
