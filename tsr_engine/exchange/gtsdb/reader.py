"""Reads ``gt.txt``, of the benchmark or of ours."""

from __future__ import annotations

from pathlib import Path

from tsr_engine.exchange.box_rules import Edges
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.file_listing import first_row
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.frame_numbering import NumberingScheme
from tsr_engine.exchange.frames_of_pictures import frames_of_pictures
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.labels import benchmark_keys
from tsr_engine.exchange.linking import UntrackedBoxes
from tsr_engine.exchange.nearby_manifest import is_wrapper, manifest_value
from tsr_engine.exchange.picture_sequences import ListedPicture, read_picture_list
from tsr_engine.exchange.reading import read_text, rule_error
from tsr_engine.exchange.truncated_files import last_byte, report_truncated
from tsr_engine.io.plain_numbers import parse_whole

GROUND_TRUTH_FILE = "gt.txt"
PICTURE_LIST = "pictures.txt"
_BENCHMARK = NumberingScheme(0, "the benchmark's scenes begin with 00000", prefix_pattern="", digits=5)


def read_gtsdb(path: Path, target: ImportTarget) -> Dataset:
    """Read a ``gt.txt``, or one in the folder of each subset.

    Args:
        path: the file, or the folder that has it.
        target: the video that the file is about.

    Raises:
        ImportFormatError: a row breaks a rule.
    """
    validator = ImportValidator(target)
    files = _files(path)
    if not files:
        raise rule_error(path.name, None, f"has no {GROUND_TRUTH_FILE}. Name the folder that has it.")
    folder = path if path.is_dir() else path.parent
    corners = target.switches.get("corners", "auto")
    if corners == "auto":
        corners = manifest_value(folder, "corners") or "inclusive"
    rows = [
        (file.relative_to(folder).as_posix(), line, content)
        for file in files
        for line, content in enumerate(read_text(file).splitlines(), start=1)
        if content.strip()
    ]
    report_truncated(((file.relative_to(folder).as_posix(), last_byte(file)) for file in files), validator)
    listed: dict[tuple[str, str], ListedPicture] = {}
    for name, line, content in rows:
        picture = _cells(content, name, line)[0]
        if (name, picture) not in listed:
            listed[name, picture] = ListedPicture(picture, name, line, scheme=_BENCHMARK)
    listed_names = [picture for file in files for picture in read_picture_list(file.parent / PICTURE_LIST)]
    frames = dict(zip(listed, frames_of_pictures(list(listed.values()), validator, folder, listed_names), strict=True))
    loose = UntrackedBoxes(validator, files[0].name)
    for name, line, content in rows:
        cells = _cells(content, name, line)
        frame = frames[name, cells[0]]
        if frame is not None:
            _read_row(cells, frame, name, line, corners, validator, loose)
    loose.finish()
    return validator.finish(files[0].name)


def _cells(content: str, file: str, line: int) -> list[str]:
    cells = [cell.strip() for cell in content.split(";")]
    if len(cells) != 6:
        raise rule_error(file, line, f"must be file;left;top;right;bottom;class. Got {content.strip()[:60]!r}.")
    return cells


def _read_row(
    cells: list[str], frame: int, file: str, line: int, corners: str, validator: ImportValidator, loose: UntrackedBoxes
) -> None:
    label = _whole(cells[5], cells, file, line)
    if not 0 <= label < len(benchmark_keys()):
        raise rule_error(file, line, f"class {label} must be 0 to {len(benchmark_keys()) - 1}. Correct it.")
    edges = validator.boxes.edges(lambda: _edges(cells, 1 if corners == "inclusive" else 0, file, line))
    loose.add(frame, edges, validator.label(benchmark_keys()[label], file, line), file=file, line=line)


def _edges(cells: list[str], extra: int, file: str, line: int) -> Edges:
    left, top, right, bottom = (_whole(cell, cells, file, line) for cell in cells[1:5])
    if min(left, top) < 0 or max(left, top, right, bottom) > 1_000_000:
        raise rule_error(file, line, f"corners must be pixels from 0. Got {left};{top};{right};{bottom}.")
    return left, top, right + extra, bottom + extra


def _whole(cell: str, cells: list[str], file: str, line: int) -> int:
    try:
        return parse_whole(cell)
    except ValueError:
        raise rule_error(file, line, f"must have whole numbers after the file. Got {';'.join(cells)[:60]!r}.") from None


def _files(path: Path) -> list[Path]:
    if path.is_file():
        return [path]
    if (path / GROUND_TRUTH_FILE).is_file():
        return [path / GROUND_TRUTH_FILE]
    return sorted(path.glob(f"*/{GROUND_TRUTH_FILE}"))


def sniff_gtsdb(path: Path) -> bool:
    """Whether a file or folder looks like GTSDB's."""
    if is_wrapper(path):
        return False
    for file in _files(path)[:1] if path.is_dir() or path.suffix.lower() in (".txt", ".csv") else []:
        line = first_row(file)
        return line.count(";") == 5 and "Roi" not in line if line else (file.parent / PICTURE_LIST).is_file()
    return False
