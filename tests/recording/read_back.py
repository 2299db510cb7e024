"""A recording as plain values, read by the SDK's reader."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np


class ReadBack:
    """All chunks of a recording."""

    def __init__(self, path: Path) -> None:
        from rerun.chunk import RrdReader

        self.chunks = list(RrdReader(path).stream().collect().stream())

    def of(self, entity: str, static: bool = False) -> list[Any]:
        """The tables of an entity."""
        return [
            chunk.to_record_batch()
            for chunk in self.chunks
            if chunk.entity_path == f"/{entity}" and chunk.is_static == static
        ]

    def entities(self) -> set[str]:
        """Entity paths without the leading slash; the viewer's own are left out."""
        return {chunk.entity_path[1:] for chunk in self.chunks}

    def column(self, entity: str, name: str) -> dict[int, Any]:
        """Frame -> values of one component; empty lists are kept."""
        found: dict[int, Any] = {}
        for batch in self.of(entity):
            column = next((c for c in batch.schema.names if c.endswith(name)), None)
            if column is None:
                continue
            frames = batch.column(batch.schema.names.index("frame")).to_pylist()
            values = batch.column(batch.schema.names.index(column)).to_pylist()
            found.update(dict(zip(frames, values, strict=True)))
        return found

    def static(self, entity: str, name: str) -> Any:
        """The value of a component that never changes."""
        for batch in self.of(entity, static=True):
            for column in batch.schema.names:
                if column.endswith(name):
                    return batch.column(batch.schema.names.index(column)).to_pylist()[0]
        return None

    def boxes(self, entity: str) -> dict[int, np.ndarray]:
        """Frame -> edges of its boxes, shape (n, 4), px."""
        centres, halves = self.column(entity, "Boxes2D:centers"), self.column(entity, "Boxes2D:half_sizes")
        assert centres.keys() == halves.keys()
        found = {}
        for frame, middle in centres.items():
            a = np.array(middle or [], np.float64).reshape(-1, 2)
            b = np.array(halves[frame] or [], np.float64).reshape(-1, 2)
            found[frame] = np.hstack([a - b, a + b])
        return found
