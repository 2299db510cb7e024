"""Detects data sets whose pictures Roboflow has changed, because their boxes do not fit the video."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

from tsr_engine.exchange.dataset import DatasetVideo
from tsr_engine.exchange.reading import rule_error

_README: Final = "README.roboflow.txt"
_PREPROCESSING_STEP = re.compile(r"\s*\*\s*(?P<step>\S.*)")
_RESIZED = re.compile(r"Resize to (?P<width>\d{1,5})x(?P<height>\d{1,5}) \((?:Fit \(|Fill)", re.IGNORECASE)
"""Steps that pad or crop pictures; "stretch" and "fit within" keep all parts of a picture."""
_MOVES_SIGNS = re.compile(r"\b(?:flip|rotat\w*|shear|crop|tiles?|mosaic)\b", re.IGNORECASE)


def refuse_changed_pictures(folder: Path, video: DatasetVideo) -> None:
    """Refuse a data set whose notes describe changes that move signs within its pictures.

    Args:
        folder: the import's folder; the notes may lie above the folder of a subset.
        video: the import's video.

    Raises:
        ImportFormatError: pictures were rotated, flipped, cropped or padded.
    """
    path = next((place / _README for place in (folder, folder.parent) if (place / _README).is_file()), None)
    if path is None:
        return
    text = path.read_bytes()[: 1 << 16].decode("utf-8", "replace")
    for line, content in enumerate(text.splitlines(), start=1):
        found = _PREPROCESSING_STEP.fullmatch(content)
        if found is None:
            continue
        step = found["step"].strip()
        size = _RESIZED.match(step)
        if size is None and not _MOVES_SIGNS.search(step):
            continue
        # A picture with the same aspect ratio is neither padded nor cropped.
        if size is not None and int(size["width"]) * video.height == int(size["height"]) * video.width:
            continue
        raise rule_error(
            _README,
            line,
            f"says of the pictures: {step[:80]!r}. Their boxes do not fit {video.name}. Export a version "
            "without augmentation, and without a change of size or with 'Stretch to'.",
        )
