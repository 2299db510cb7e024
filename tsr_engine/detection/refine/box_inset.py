"""Box inset: shrinks boxes, because annotators of the training scenes left a margin around signs."""

from __future__ import annotations

from dataclasses import dataclass

from tsr_engine.geometry.boxes import to_cxcywh, to_xyxy
from tsr_engine.params.detector import DetectorParams
from tsr_engine.records import FloatArray

__all__ = ["BoxInset"]


@dataclass(frozen=True, slots=True)
class BoxInset:
    """Factors that turn a box in the style of the training annotations into the box that is reported.

    Attributes:
        width: factor on the width, > 0.
        height: factor on the height, > 0.
        rise: shift upwards, as a share of the annotated height.
    """

    width: float
    height: float
    rise: float

    @classmethod
    def of(cls, params: DetectorParams) -> BoxInset:
        """The box inset of the parameters."""
        return cls(params.inset_width, params.inset_height, params.inset_rise)

    def apply(self, boxes: FloatArray) -> FloatArray:
        """Boxes (n, 4) as reported, from annotation-style boxes (n, 4)."""
        b = to_cxcywh(boxes)
        b[:, 1] -= self.rise * b[:, 3]
        b[:, 2] *= self.width
        b[:, 3] *= self.height
        return to_xyxy(b)

    def undo(self, boxes: FloatArray) -> FloatArray:
        """Annotation-style boxes (n, 4), from boxes (n, 4) as reported."""
        b = to_cxcywh(boxes)
        b[:, 2] /= self.width
        b[:, 3] /= self.height
        b[:, 1] += self.rise * b[:, 3]
        return to_xyxy(b)
