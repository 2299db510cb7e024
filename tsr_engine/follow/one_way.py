"""Follows a sign in one direction, frame by frame away from an anchor.

Each frame predicts the box from the sign's path and the camera's shift, searches for the known templates, lets the
detector's later stages set the edges of known shapes, and computes the confidence.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from tsr_engine.follow.confidence import KEPT, LEARNED, Evidence
from tsr_engine.follow.known_shape import KnownShape, know
from tsr_engine.follow.path import SignPath
from tsr_engine.follow.pixels import PicturePixels
from tsr_engine.follow.records import Direction, FollowerModels, Source
from tsr_engine.follow.search import Match, search
from tsr_engine.follow.template import Template, size_of
from tsr_engine.geometry.boxes import area, clip, iou_each, to_cxcywh
from tsr_engine.online.features import describe
from tsr_engine.online.online_detector import OnlineDetector, usable
from tsr_engine.records import FloatArray, Picture

__all__ = ["OneWay", "Step", "visible_share"]

_TEMPLATES: Final = 14
"""Looks that are remembered."""
_COMPARED: Final = 3
"""... and compared in each frame: those of the most similar size, an anchor's among them."""
_NEW_SIZE: Final = math.log(1.2)
"""A look is worth remembering at a size that differs by this from all that are known."""
_LIKELY: Final = 0.5
"""Below this similarity the expected place is judged instead of the match, which then counts if it lies there."""
_THERE: Final = 0.5
"""IoU of a match with the expected place from which it lies there."""
_UNCERTAIN: Final = 0.7
"""Below this similarity the search is repeated farther away."""
_BETTER: Final = 0.1
"""... and must be better by this to count."""
_SPREAD_FAR: Final = 0.16
"""How far the size may differ in that search at least, natural logarithm."""
_WHOLE: Final = 0.98
"""Visible share from which on a look is learned."""


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One frame's result.

    Attributes:
        box: shape (4,), px; may reach beyond the picture.
        confidence: see :class:`tsr_engine.follow.records.Proposal`.
        source: what the box comes from.
        place_error: standard deviation of the centre, px.
        size_error: ... of the natural logarithm of the size.
        evidence: what it rests on; None for a repeated picture before anything was seen.
    """

    box: FloatArray
    confidence: float
    source: Source
    place_error: float
    size_error: float
    evidence: Evidence | None

    def within(self, error: float) -> Step:
        """The same, if the box that it began with is wrong by a share of its size."""
        place = math.hypot(self.place_error, error * size_of(self.box))
        return replace(self, place_error=place, size_error=math.hypot(self.size_error, error))


class OneWay:
    """Follows one sign from an anchor on.

    Args:
        picture: of the anchor's frame.
        box: the anchor's, shape (4,), px.
        templates: looks of all anchors.
        direction: of time.
        parts: the trained parts.

    Attributes:
        hidden: frames since the sign was seen; 0: it is seen.
    """

    def __init__(
        self, picture: Picture, box: FloatArray, templates: list[Template], direction: Direction, parts: FollowerModels
    ) -> None:
        self.hidden = 0
        self._size = (picture.shape[1], picture.shape[0])
        self._path = SignPath(box, self._size, direction)
        self._templates = list(templates)
        self._stretch = math.sqrt((box[2] - box[0]) / (box[3] - box[1]))
        self._shape: KnownShape | None = know(parts.look, picture, box)
        self._online: OnlineDetector | None = None
        if parts.make_online is not None and usable(box):
            self._online = parts.make_online(PicturePixels(picture), box, 0)[0]
        self._frames = 0
        self._waiting = 0
        self._last = Step(box, 1.0, "matched", self._path.place_error, self._path.size_error, None)

    def step(self, picture: Picture, shift: tuple[float, float], repeated: bool = False, learn: bool = True) -> Step:
        """Take the next frame.

        Args:
            picture: BGR, uint8, of the same size as the anchor's.
            shift: of the camera since the frame before, px.
            repeated: the picture is the one before once more.
            learn: whether its pixels may be remembered.
        """
        self._frames += 1
        self._waiting += 1
        if repeated:
            return self._last
        self._path.predict(float(self._waiting), shift)
        self._waiting = 0
        self._last = self._judged(picture, learn)
        return self._last

    def _judged(self, picture: Picture, learn: bool) -> Step:
        expected = self._path.box
        if not self._in_view(expected):
            return self._hide(expected, 0.0, None)
        match, place_error = self._match(picture, expected)
        where = expected if match is None or match.similarity < _LIKELY else match.box
        found = match is not None and float(iou_each(match.box, where)[0]) >= _THERE
        seen = None if self._shape is None else self._shape.at(picture, where)
        size = size_of(expected)
        evidence = Evidence(
            similarity=0.0 if match is None else match.similarity,
            anchor_similarity=0.0 if match is None else match.anchor_similarity,
            away=float(np.hypot(*(to_cxcywh(where) - to_cxcywh(expected))[:2])) / (place_error + 0.05 * size),
            grown=abs(math.log(size_of(where) / size)) / (self._path.size_error + 0.02),
            decision=self._decision(picture, where),
            score=None if seen is None else seen.score,
        )
        confidence = evidence.confidence
        measured = found or (seen is not None and seen.box is not None)
        if confidence < KEPT or not measured:
            return self._hide(expected, confidence, evidence)
        self.hidden = 0
        if match is not None and found:
            self._path.correct(match.box, math.sqrt(match.variance))
        if seen is not None and seen.box is not None:
            self._path.correct(seen.box, seen.error)
        box = self._path.box
        if learn and confidence >= LEARNED:
            self._learn(picture, box)
        source: Source = "detected" if seen is not None and seen.box is not None else "matched"
        return Step(box, confidence, source, self._path.place_error, self._path.size_error, evidence)

    def _hide(self, expected: FloatArray, confidence: float, evidence: Evidence | None) -> Step:
        self.hidden += 1
        return Step(expected, confidence, "predicted", self._path.place_error, self._path.size_error, evidence)

    def _match(self, picture: Picture, expected: FloatArray) -> tuple[Match | None, float]:
        """The best match near the expected box, or farther away; and the error of the place that was allowed."""
        error, spread = self._path.place_error, min(3.0 * self._path.size_error, 0.3)
        widest = 1.2 * float(max(expected[2:] - expected[:2])) + 24.0
        radius = min(3.0 * error + 3.0, widest)
        near = self._comparable(size_of(expected))
        match = search(picture, near, expected, self._stretch, radius, spread)
        similarity = 0.0 if match is None else match.similarity
        # A sign that stays hidden is not worth a wide search in every frame.
        due = self.hidden & (self.hidden - 1) == 0
        if radius < 0.7 * widest and similarity < _UNCERTAIN and due:
            farther = search(picture, near, expected, self._stretch, widest, max(spread, _SPREAD_FAR))
            if farther is not None and farther.similarity > max(similarity + _BETTER, _UNCERTAIN):
                return farther, widest / 3.0
        return match, error

    def _comparable(self, size: float) -> list[Template]:
        """The templates to compare at a size, the best first."""
        ranked = sorted(self._templates, key=lambda template: abs(math.log(size / template.size)))
        chosen = ranked[:_COMPARED]
        if not any(template.anchor for template in chosen):
            chosen[-1] = next(template for template in ranked if template.anchor)
        return chosen

    def _decision(self, picture: Picture, box: FloatArray) -> float | None:
        if self._online is None or not usable(box) or not self._in_view(box):
            return None
        described = describe(PicturePixels(picture), box)
        return float(self._online.svm.decision_function(described[None])[0])

    def _learn(self, picture: Picture, box: FloatArray) -> None:
        """Remember the look of a sure box, if it is of a new size and wholly seen."""
        size = size_of(box)
        if min(abs(math.log(size / template.size)) for template in self._templates) < _NEW_SIZE:
            return
        if visible_share(box, *self._size) < _WHOLE:
            return
        self._templates.append(Template.cut(picture, box, max(self._path.size_error**2, 1e-5), False))
        if len(self._templates) > _TEMPLATES:
            self._templates.remove(next(template for template in self._templates if not template.anchor))
        if self._online is not None and usable(box):
            self._online.learn(PicturePixels(picture), box, 1, self._frames)

    def _in_view(self, box: FloatArray) -> bool:
        return visible_share(box, *self._size) > 0.0


def visible_share(box: FloatArray, width: int, height: int) -> float:
    """The share of a box, shape (4,), that lies in a picture of width x height px."""
    whole = float(area(box))
    return float(area(clip(box, width, height))) / whole if whole > 0.0 else 0.0
