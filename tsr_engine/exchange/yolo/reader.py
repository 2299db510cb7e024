"""Reads YOLO: label files, class names, tracks from ``tracks.csv`` or from a sixth column.

The meaning of a sixth column is decided once for all files: a confidence if a number has a fraction, or if a picture
has the same number twice; else a track id. Rows with both (``class cx cy w h confidence id``) and polygons are
read too; see :mod:`~.row_shapes`.
"""

from __future__ import annotations

import math
import re
from collections import Counter, deque
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from tsr_engine.exchange.box_rules import NO_BOX
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.frame_numbering import NumberingScheme
from tsr_engine.exchange.frames_of_pictures import frames_of_pictures
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.labels import benchmark_keys
from tsr_engine.exchange.linking import UntrackedBoxes
from tsr_engine.exchange.nearby_manifest import visible_entries
from tsr_engine.exchange.picture_sequences import ListedPicture, read_picture_list
from tsr_engine.exchange.reading import MAX_JSON_BYTES, decode_text, read_names, rule_error
from tsr_engine.exchange.sidecar import SidecarRow, read_sidecar
from tsr_engine.exchange.small_file_store import SmallFileStore, list_all_files, read_content
from tsr_engine.exchange.truncated_files import report_truncated
from tsr_engine.exchange.yolo.class_names import read_data_yaml
from tsr_engine.exchange.yolo.row_shapes import YoloLine, YoloRow, rows_to_boxes
from tsr_engine.io.plain_numbers import parse_real
from tsr_engine.plural import plural

SIDECAR = "tracks.csv"
SIDECAR_COLUMNS = ("file", "line", "row")
YAML_FILES = ("data.yaml", "dataset.yaml", "data.yml")
"""Usual names of the file with the class names."""
_PICTURE_LISTS = ("train.txt", "val.txt", "valid.txt", "test.txt", "images.txt")
"""Lists of pictures in darknet, CVAT and FiftyOne."""
_NOT_LABEL_FILES = frozenset({*_PICTURE_LISTS, "classes.txt", "readme.txt", "labels.txt"})
_NOTE_PREFIXES = ("readme.", "autosplit_")
"""Prefixes of other text files of Roboflow and Ultralytics."""
_CVAT_FOLDER = re.compile("obj_.+_data")
"""CVAT's folder of a subset."""
_SUBSETS = frozenset({"train", "val", "valid", "test"})
_SAVE_TXT_SCHEME = NumberingScheme(
    1,
    "Ultralytics' save_txt names the file of a video's first frame NAME_1.txt",
    prefix_pattern=r"(?!(?:frames?|img|images?|pictures?)_\Z).*[^\W_]_",
)


def label_files(path: Path, store: SmallFileStore | None = None) -> list[str]:
    """Names of the label files of a folder, relative to it, sorted; only those below ``labels`` if that exists."""
    # Plain strings, because a folder can hold 100,000 files.
    named = [(name, name.split("/")) for name in list_all_files(path, store)]
    found = [(n, parts) for n, parts in named if n.endswith(".txt") and _may_be_labels(parts[-1].lower())]
    inside = [
        name for name, parts in found if any(part == "labels" or _CVAT_FOLDER.fullmatch(part) for part in parts[:-1])
    ]
    return inside or [name for name, _ in found]


def is_label_file(path: Path) -> bool:
    """Whether a text file has rows of a class, four relative coordinates, and at most two more numbers."""
    with path.open("rb") as stream:
        rows = [row for row in stream.readlines(1 << 12) if row.strip()]
    for row in rows:
        try:
            number, *values = (parse_real(cell) for cell in row.decode("latin-1").split())
        except ValueError:
            return False
        if (
            not number.is_integer()
            or not 4 <= len(values) <= 6
            or not all(-0.01 <= part <= 1.01 for part in values[:4])
        ):
            return False
    return bool(rows)


def _may_be_labels(name: str) -> bool:
    return name not in _NOT_LABEL_FILES and not name.startswith(_NOTE_PREFIXES)


def read_yolo(path: Path, target: ImportTarget) -> Dataset:
    """Read a folder.

    Raises:
        ImportFormatError: a row breaks a rule.
    """
    if path.is_file():
        raise rule_error(path.name, None, "is one file; YOLO is a folder with data.yaml and labels. Pack the folder.")
    validator = ImportValidator(target)
    files = label_files(path, target.store)
    if not files and not (path / SIDECAR).is_file():
        raise rule_error(path.name, None, "has no label files (labels/train/frame_000010.txt). Export as YOLO again.")
    if [name.rpartition("/")[2] for name in files] == ["image0.txt"]:
        rule = (
            "Ultralytics writes all pictures that a program passes one by one into this file, without their frames. "
            "Run it on the video file, or call the file of a single picture frame_000000.txt, with its frame."
        )
        raise rule_error(files[0], None, rule)
    names, names_file, keypoint_count = _class_names(path, files)
    if names is not None and _are_benchmark_numbers(names):
        names = dict(enumerate(benchmark_keys()))
        validator.repair(
            f"{names_file}: {len(names)} classes have their numbers as names, which were taken as those of GTSRB."
        )
    listed_names = [picture for name in _PICTURE_LISTS for picture in read_picture_list(path / name)]
    frames = frames_of_pictures([_listed(name) for name in files], validator, path, listed_names)
    found: list[YoloLine] = []
    file_ends: list[tuple[str, bytes]] = []
    for name, frame in zip(files, frames, strict=True):
        if frame is None:
            continue
        content = read_content(f"{path}/{name}", target.store, MAX_JSON_BYTES + 1)
        lines = decode_text(content, name.rpartition("/")[2])
        file_ends.append((name, content[-1:]))
        if lines.strip():
            found += _lines(lines, name, frame, names, names_file, validator)
    report_truncated(file_ends, validator)
    rows = rows_to_boxes(found, keypoint_count, validator)
    if names is None and rows:
        validator.repair(f"{path.name}: has no class names (data.yaml); class numbers were taken as those of the tool.")
    loose = UntrackedBoxes(validator, path.name)
    if any(row.extra_values for row in rows):
        _add_with_columns(rows, validator, loose)
    elif (path / SIDECAR).is_file():
        _add_with_sidecar(rows, path / SIDECAR, validator, loose)
    else:
        for row in rows:
            loose.add(row.frame, row.edges, row.label, file=row.file, line=row.line)
    loose.finish()
    return validator.finish(path.name)


def _listed(name: str) -> ListedPicture:
    in_subset = not _SUBSETS.isdisjoint(name.split("/")[:-1])
    return ListedPicture(name, name, scheme=None if in_subset else _SAVE_TXT_SCHEME)


def _class_names(path: Path, files: list[str]) -> tuple[dict[int, str] | None, str, int]:
    """Names by number, the file that has them, and how many numbers keypoints have; None: no file has names."""
    keypoint_count = 0
    for file in _yaml_files(path):
        found = read_data_yaml(file)
        keypoint_count = keypoint_count or found.keypoint_count
        if found.names is not None:
            return found.names, file.name, keypoint_count
    for name in ("classes.txt", "obj.names", "labels/classes.txt", "labels.txt"):
        if (path / name).is_file():
            return dict(enumerate(read_names(path / name))), name, keypoint_count
    return *_class_names_beside(path, files), keypoint_count


def _yaml_files(path: Path) -> Iterator[Path]:
    """The files that may describe the data set, the first ones first."""
    for folder in (path, path.parent):
        yield from (file for name in YAML_FILES if (file := folder / name).is_file())
    yield from _other_yaml(path)


def _class_names_beside(path: Path, files: list[str]) -> tuple[dict[int, str] | None, str]:
    """Names in the ``classes.txt`` that labelImg writes into each folder of label files.

    Raises:
        ImportFormatError: two folders have different names.
    """
    folders = dict.fromkeys(name.rpartition("/")[0] for name in files if "/" in name)
    lists = [name for folder in folders if (path / (name := f"{folder}/classes.txt")).is_file()]
    found = [read_names(path / name) for name in lists]
    if not found:
        return None, ""
    for name, names in zip(lists, found, strict=True):
        if names != found[0]:
            raise rule_error(name, None, f"has other classes than {lists[0]}. Import the folders one by one.")
    return dict(enumerate(found[0])), lists[0]


def _are_benchmark_numbers(names: dict[int, str]) -> bool:
    """Whether the classes of a file are called 0 to 42, as is common for GTSRB."""
    return len(names) == len(benchmark_keys()) and all(
        text.isdecimal() and int(text) == number for number, text in names.items()
    )


def _other_yaml(path: Path) -> list[Path]:
    """The only other YAML file with class names: Ultralytics allows any name."""
    files = [file for file in visible_entries(path) if file.suffix in (".yaml", ".yml") and file.name not in YAML_FILES]
    return files if len(files) == 1 else []


def _lines(
    text: str, file: str, frame: int, names: dict[int, str] | None, names_file: str, validator: ImportValidator
) -> Iterator[YoloLine]:
    for line, content in enumerate(text.splitlines(), start=1):
        cells = content.split()
        if not cells:
            continue
        values = validator.boxes.edges(partial(_values, cells, file, line))
        if values is NO_BOX:
            continue
        number = values[0]
        if number != int(number) or number < 0:
            raise rule_error(file, line, f"the class must be a whole number from 0 on. Got {cells[0][:40]}.")
        if names is not None and int(number) not in names:
            raise rule_error(
                file, line, f"class {int(number)} is none of the {len(names)} classes in {names_file}. Add it."
            )
        name = str(int(number)) if names is None else names[int(number)]
        label = validator.label(name, file, line, number=names is None)
        yield YoloLine(file, line, frame, content.strip(), label, values[1:])


def _values(cells: list[str], file: str, line: int) -> tuple[float, ...]:
    """The numbers of a row: the class, at least four of the box, and others."""
    row = " ".join(cells)[:60]
    try:
        values = tuple(parse_real(cell) for cell in cells)
    except ValueError:
        raise rule_error(file, line, f"must be numbers. Got {row!r}. Correct it.") from None
    if not all(math.isfinite(value) for value in values):
        raise rule_error(file, line, f"must be finite numbers. Got {row!r}. Correct it.")
    if len(values) < 5:
        raise rule_error(
            file, line, f"must have 5 columns: class, centre x, centre y, width, height. Got {len(values)}."
        )
    return values


def _add_with_columns(rows: list[YoloRow], validator: ImportValidator, loose: UntrackedBoxes) -> None:
    """Take rows with columns after the box: a track id, a confidence, or both."""
    option = validator.target.switches.get("column6", "auto")
    sixth = [row for row in rows if len(row.extra_values) == 1]
    kind, reason = (option, "as you said") if option != "auto" else _meaning_of_sixth_column(sixth)
    for row in rows:
        score, track = math.nan, None
        if len(row.extra_values) == 2:
            score, track = row.extra_values
        elif row.extra_values and kind == "confidence":
            score = row.extra_values[0]
        elif row.extra_values:
            track = row.extra_values[0]
        if track is None:
            loose.add(row.frame, row.edges, row.label, file=row.file, line=row.line, score=score)
            continue
        if track != int(track) or not 0 <= track < 1e15:
            raise rule_error(row.file, row.line, f"the track id must be a whole number from 0 on. Got {track:g}.")
        validator.box(f"track{int(track)}", row.frame, row.edges, row.label, file=row.file, line=row.line, score=score)
    if sixth:
        first = sixth[0]
        meaning = "confidences" if kind == "confidence" else "track ids"
        validator.repair(
            f"{first.file}, line {first.line}: YOLO has 5 columns; the sixth of {plural(len(sixth), 'row')} was "
            f"taken as {meaning}: {reason} (column6)."
        )


def _meaning_of_sixth_column(rows: list[YoloRow]) -> tuple[str, str]:
    """Decide over all files between ``track`` and ``confidence``; return it with the reason.

    Raises:
        ImportFormatError: neither is possible.
    """
    all_whole = all(row.extra_values[0] == int(row.extra_values[0]) for row in rows)
    invalid = next(
        (row for row in rows if row.extra_values[0] < 0 or (row.extra_values[0] > 1 and not all_whole)), None
    )
    if invalid is not None:
        raise rule_error(
            invalid.file,
            invalid.line,
            f"the sixth column must be track ids (whole numbers from 0 on) or confidences (0 to 1) in all files. Got "
            f"{invalid.extra_values[0]:g}. Delete the column.",
        )
    if not all_whole:
        return "confidence", "some have a fraction and all are in 0 to 1"
    counts = Counter((row.file, row.extra_values[0]) for row in rows)
    if all(row.extra_values[0] <= 1 for row in rows) and max(counts.values(), default=0) > 1:
        return "confidence", "all are 0 or 1 and one picture has the same twice"
    return "track", "all are whole numbers"


def _add_with_sidecar(rows: list[YoloRow], path: Path, validator: ImportValidator, loose: UntrackedBoxes) -> None:
    """Take rows whose tracks the side file names: by their text, else by their line."""
    entries_by_file: dict[str, list[SidecarRow]] = {}
    for sidecar_row in read_sidecar(path, SIDECAR_COLUMNS):
        entries_by_file.setdefault(sidecar_row.format_cells["file"], []).append(sidecar_row)
    by_file: dict[str, list[YoloRow]] = {}
    for row in rows:
        by_file.setdefault(row.file, []).append(row)
    for file, file_rows in by_file.items():
        for row, entry in _match_sidecar(file_rows, entries_by_file.get(file, []), validator):
            if entry is None:
                validator.count(f"Boxes without a row in {path.name}", row.file, row.line)
                loose.add(row.frame, row.edges, row.label, file=row.file, line=row.line)
                continue
            entry.add(validator, row.frame, row.edges, row.label, row.file, row.line)


def _match_sidecar(
    rows: list[YoloRow], entries: list[SidecarRow], validator: ImportValidator
) -> list[tuple[YoloRow, SidecarRow | None]]:
    by_text: dict[str, deque[SidecarRow]] = {}
    for entry in entries:
        by_text.setdefault(entry.format_cells["row"], deque()).append(entry)
    out: list[tuple[YoloRow, SidecarRow | None]] = []
    for row in rows:
        candidates = by_text.get(row.text)
        out.append((row, candidates.popleft() if candidates else None))
    unmatched = [entry for candidates in by_text.values() for entry in candidates]
    without_entry = [index for index, (_, entry) in enumerate(out) if entry is None]
    # Moved boxes keep their line if none was added or deleted.
    if without_entry and len(rows) == len(entries):
        unmatched.sort(key=lambda entry: entry.line)
        for index, kept in zip(without_entry, unmatched, strict=True):
            row = out[index][0]
            validator.count("Boxes changed since the export kept the track of their line", row.file, row.line)
            out[index] = (row, kept)
    return out
