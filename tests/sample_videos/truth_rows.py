"""Rows of a drive's ground truth, read back."""

from __future__ import annotations

import csv
from pathlib import Path

from sample_videos.ground_truth import HEADER, Row

WHOLE = {"frame", "track_id", "class_id", "ignore"}
"""Columns of whole numbers."""


def read_rows(path: Path) -> list[Row]:
    """Rows of a CSV file of ``write_csv``."""
    with path.open(newline="", encoding="utf-8") as file:
        lines = csv.DictReader(file)
        assert tuple(lines.fieldnames or ()) == HEADER
        return [Row(**{name: (int if name in WHOLE else float)(cell) for name, cell in line.items()}) for line in lines]
