"""Finds the files of a video's sequence in a folder, and reads its name and size from them."""

from __future__ import annotations

import configparser
import io
import math
import re
from dataclasses import dataclass
from pathlib import Path

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.mot.row_values import LABELS_FILE
from tsr_engine.exchange.nearby_manifest import is_named_after
from tsr_engine.exchange.reading import read_names, read_text, rule_error
from tsr_engine.exchange.split import SUBSETS
from tsr_engine.exchange.video_matching import name_similarity
from tsr_engine.exchange.video_names import safe_stem
from tsr_engine.io.plain_numbers import parse_real
from tsr_engine.plural import plural

_SEQUENCE_FILE = "seqinfo.ini"
_GENERIC_NAME = re.compile(
    "(?:^|[^a-z])(?:gt|det|mot|track|result|out|pred|label|annot|export|data|row|box|truth|tmp|file|train|val|test)",
    re.I,
)
"""Words in file and folder names that do not name a video."""


@dataclass(frozen=True, slots=True)
class SequenceFiles:
    """Files of a sequence; ``root`` has ``seqinfo.ini``."""

    root: Path
    rows: Path


def find_sequences(path: Path, validator: ImportValidator) -> list[SequenceFiles]:
    """The sequences of a folder or row file that are about the video; the others are reported.

    Raises:
        ImportFormatError: there is no sequence, or several and none has the video's name.
    """
    video = validator.target.video
    if path.is_file():
        if not _GENERIC_NAME.search(path.stem):
            _report_other_name(path.stem, path.parent, path.name, validator)
        root = path.parent.parent if path.parent.name in ("gt", "det") else path.parent
        return [SequenceFiles(root, path)]
    for part in ("gt/gt.txt", "det/det.txt", "gt.txt", "det.txt"):
        if (path / part).is_file():
            wrapper = validator.target.wrapper
            if not _GENERIC_NAME.search(wrapper):
                _report_other_name(wrapper, path, wrapper, validator)
            return [SequenceFiles(path, path / part)]
    parts = sorted(path.rglob("gt/gt.txt"))
    if not parts:
        raise rule_error(path.name, None, "has neither gt/gt.txt nor det/det.txt. Export as MOT 1.1 again.")
    names = {part: part.parent.parent.name for part in parts}
    matching = [
        part for part in parts if name_similarity(names[part], video) or is_named_after(path, video, names[part])
    ] or [part for part in parts if part.parent.parent.parent == path and names[part] in SUBSETS]
    if not matching and len(parts) == 1:
        matching = parts
        if not _GENERIC_NAME.search(names[parts[0]]):
            _report_other_name(names[parts[0]], path, path.name, validator)
    if not matching:
        raise ImportFormatError(
            f"{path.name}: has {len(parts)} sequences ({', '.join(list(names.values())[:5])}), none called "
            f"{safe_stem(video.name)}. Import the folder of one of them."
        )
    others = [name for part, name in names.items() if part not in matching]
    if others:
        validator.skip(
            f"{path.name}: {plural(len(others), 'sequence')}",
            f"They are not about {video.name}: {', '.join(others[:8])}.",
        )
    return [SequenceFiles(part.parent.parent, part) for part in matching]


def _report_other_name(name: str, folder: Path, file: str, validator: ImportValidator) -> None:
    """Report a sequence with another video's name."""
    video = validator.target.video
    if name and not name_similarity(name, video) and not is_named_after(folder, video, name):
        validator.repair(f"{file}: names {name[:80]}. It was imported onto {video.name}.")


def class_names(sequence: SequenceFiles) -> list[str] | None:
    """Class names from the file beside the rows; None: there is no file."""
    for path in (sequence.rows.parent / LABELS_FILE, sequence.root / "gt" / LABELS_FILE, sequence.root / LABELS_FILE):
        if path.is_file():
            return read_names(path)
    return None


def picture_scale(sequence: SequenceFiles, folder: Path, validator: ImportValidator) -> tuple[float, float]:
    """Factors from the sequence's picture size to the video's, by ``seqinfo.ini`` if there is one.

    A name, length or rate that differs from the video's is reported.

    Raises:
        ImportFormatError: the file cannot be read, or the pictures have another size.
    """
    path = sequence.root / _SEQUENCE_FILE
    if not path.is_file():
        return 1.0, 1.0
    parser = configparser.ConfigParser(interpolation=None)
    try:
        parser.read_file(io.StringIO(read_text(path, limit=1 << 20)))
        fields = parser["Sequence"] if parser.has_section("Sequence") else {}
        length, rate, width, height = (
            parse_real(fields[name]) if fields.get(name) else math.nan
            for name in ("seqLength", "frameRate", "imWidth", "imHeight")
        )
    except (configparser.Error, ValueError) as error:
        first = str(error).splitlines()[0]
        raise rule_error(path.name, None, f"must have whole numbers in [Sequence]: {first}. Correct it.") from None
    video = validator.target.video
    _report_other_name(fields.get("name", "").replace("\\", "/").rsplit("/", 1)[-1], folder, path.name, validator)
    if math.isfinite(length) and length != video.frames:
        validator.repair(f"{path.name}: its sequence has {length:g} frames, {video.name} has {video.frames}.")
    validator.check_rate(rate, path.name)
    return validator.scale(width, height, path.name) if width == width and height == height else (1.0, 1.0)
