"""What a new model version tells about itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tsr_engine.json_shapes import JsonMapping

__all__ = ["Report"]


@dataclass(frozen=True, slots=True)
class Report:
    """The result of making a model version.

    Attributes:
        figures: figures of the new version and its parent on the same data.
        lineage: exports, parent, parts, seed, settings, counts.
        models: component -> SHA-256.
    """

    figures: JsonMapping
    lineage: JsonMapping
    models: Mapping[str, str]
