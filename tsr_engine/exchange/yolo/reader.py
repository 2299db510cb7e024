"""Reads YOLO: label files, class names, tracks from ``tracks.csv`` or from a sixth column.

The meaning of a sixth column is decided once for all files: a confidence if a number has a fraction, or if a picture
has the same number twice; else a track id. Rows with both (``class cx cy w h confidence id``) and polygons are
read too; see :mod:`~.shapes`.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from tsr_engine.exchange.beside import seen_in
from tsr_engine.exchange.box_rules import NO_BOX
from tsr_engine.exchange.checks import ImportValidator
from tsr_engine.exchange.counting import Custom
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.frames_of_pictures import frames_of_pictures
from tsr_engine.exchange.labels import benchmark_keys
from tsr_engine.exchange.line_ends import tell_open_ends
from tsr_engine.exchange.linking import LooseBoxes
from tsr_engine.exchange.picture_rows import Listed, names_in
from tsr_engine.exchange.reading import MAX_JSON_BYTES, decoded, read_text, refuse
from tsr_engine.exchange.sidecar import SideRow, read_side
from tsr_engine.exchange.small_file_store import SmallFileStore, content_of, names_below
from tsr_engine.exchange.yolo.names import names_of
from tsr_engine.exchange.yolo.shapes import YoloLine, YoloRow, boxed
from tsr_engine.io.plain_numbers import real_number
from tsr_engine.plural import plural

__all__ = ["SIDE", "SIDE_OWN", "YAML_FILES", "is_label_file", "label_files", "read_yolo"]

SIDE = "tracks.csv"
SIDE_OWN = ("file", "line", "row")
YAML_FILES = ("data.yaml", "dataset.yaml", "data.yml")
"""Usual names of the file with the class names."""
_LISTS = ("train.txt", "val.txt", "valid.txt", "test.txt", "images.txt")
"""Lists of pictures in darknet, CVAT and FiftyOne."""
_NO_LABELS = frozenset({*_LISTS, "classes.txt", "readme.txt", "labels.txt"})
_NOTES = ("readme.", "autosplit_")
"""Prefixes of other text files of Roboflow and Ultralytics."""
_SUBSETS = frozenset({"train", "val", "valid", "test"})
_SAVE_TXT = Custom(
    1,
    "Ultralytics' save_txt names the file of a video's first frame NAME_1.txt",
    before=r"(?!(?:frames?|img|images?|pictures?)_\Z).*[^\W_]_",
)


def label_files(path: Path, store: SmallFileStore | None = None) -> list[str]:
    """Names of the label files of a folder, relative to it, sorted; only those below ``labels`` if that exists."""
    # Plain strings, because a folder can hold 100,000 files.
    named = [(name, name.split("/")) for name in names_below(path, store)]
    found = [(n, parts) for n, parts in named if n.endswith(".txt") and _may_be_labels(parts[-1].lower())]
    inside = [name for name, parts in found if not {"labels", "obj_train_data"}.isdisjoint(parts[:-1])]
    return inside or [name for name, _ in found]


def is_label_file(path: Path) -> bool:
    """Whether a text file has rows of a class, four relative coordinates, and at most two more numbers."""
    with path.open("rb") as stream:
        rows = [row for row in stream.readlines(1 << 12) if row.strip()]
    for row in rows:
        try:
            number, *values = (real_number(cell) for cell in row.decode("latin-1").split())
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
    return name not in _NO_LABELS and not name.startswith(_NOTES)


def read_yolo(path: Path, target: ImportTarget) -> Dataset:
    """Read a folder.

    Raises:
        ImportFormatError: a row breaks a rule.
    """
    if path.is_file():
        raise refuse(path.name, None, "is one file; YOLO is a folder with data.yaml and labels. Pack the folder.")
    validator = ImportValidator(target)
    files = label_files(path, target.store)
    if not files and not (path / SIDE).is_file():
        raise refuse(path.name, None, "has no label files (labels/train/frame_000010.txt). Export as YOLO again.")
    names, named_by = _class_names(path)
    if names is not None and _are_benchmark_numbers(names):
        names = dict(enumerate(benchmark_keys()))
        validator.repair(
            f"{named_by}: {len(names)} classes have their numbers as names, which were taken as those of GTSRB."
        )
    more = [picture for name in _LISTS for picture in names_in(path / name)]
    frames = frames_of_pictures([_listed(name) for name in files], validator, path, more)
    found: list[YoloLine] = []
    ends: list[tuple[str, bytes]] = []
    for name, frame in zip(files, frames, strict=True):
        if frame is None:
            continue
        content = content_of(f"{path}/{name}", target.store, MAX_JSON_BYTES + 1)
        lines = decoded(content, name.rpartition("/")[2])
        ends.append((name, content[-1:]))
        if lines.strip():
            found += _lines(lines, name, frame, names, named_by, validator)
    tell_open_ends(ends, validator)
    rows = boxed(found, validator)
    if names is None and rows:
        validator.repair(f"{path.name}: has no class names (data.yaml); class numbers were taken as those of the tool.")
    loose = LooseBoxes(validator, path.name)
    if any(row.rest for row in rows):
        _take_with_columns(rows, validator, loose)
    elif (path / SIDE).is_file():
        _take_with_side(rows, path / SIDE, validator, loose)
    else:
        for row in rows:
            loose.add(row.frame, row.edges, row.label, file=row.file, line=row.line)
    loose.finish()
    return validator.finish(path.name)


def _listed(name: str) -> Listed:
    in_subset = not _SUBSETS.isdisjoint(name.split("/")[:-1])
    return Listed(name, name, custom=None if in_subset else _SAVE_TXT)


def _class_names(path: Path) -> tuple[dict[int, str] | None, str]:
    """Names by number, and the file that has them; None: no file has them."""
    for file in (*(place / name for place in (path, path.parent) for name in YAML_FILES), *_other_yaml(path)):
        found = names_of(file) if file.is_file() else None
        if found is not None:
            return found, file.name
    for name in ("classes.txt", "obj.names", "labels/classes.txt", "labels.txt"):
        if (path / name).is_file():
            listed = read_text(path / name, limit=1 << 24).splitlines()
            while listed and not listed[-1].strip():
                listed.pop()
            return {place: text.strip() for place, text in enumerate(listed)}, name
    return None, ""


def _are_benchmark_numbers(names: dict[int, str]) -> bool:
    """Whether the classes of a file are called 0 to 42, as is common for GTSRB."""
    return len(names) == len(benchmark_keys()) and all(
        text.isdecimal() and int(text) == number for number, text in names.items()
    )


def _other_yaml(path: Path) -> list[Path]:
    """The only other YAML file with class names: Ultralytics allows any name."""
    files = [file for file in seen_in(path) if file.suffix in (".yaml", ".yml") and file.name not in YAML_FILES]
    return files if len(files) == 1 else []


def _lines(
    text: str, file: str, frame: int, names: dict[int, str] | None, named_by: str, validator: ImportValidator
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
            raise refuse(file, line, f"the class must be a whole number from 0 on. Got {cells[0][:40]}.")
        if names is not None and int(number) not in names:
            raise refuse(file, line, f"class {int(number)} is none of the {len(names)} classes in {named_by}. Add it.")
        name = str(int(number)) if names is None else names[int(number)]
        label = validator.label(name, file, line, number=names is None)
        yield YoloLine(file, line, frame, content.strip(), label, values[1:])


def _values(cells: list[str], file: str, line: int) -> tuple[float, ...]:
    """The numbers of a row: the class, at least four of the box, and others."""
    row = " ".join(cells)[:60]
    try:
        values = tuple(real_number(cell) for cell in cells)
    except ValueError:
        raise refuse(file, line, f"must be numbers. Got {row!r}. Correct it.") from None
    if not all(math.isfinite(value) for value in values):
        raise refuse(file, line, f"must be finite numbers. Got {row!r}. Correct it.")
    if len(values) < 5:
        raise refuse(file, line, f"must have 5 columns: class, centre x, centre y, width, height. Got {len(values)}.")
    return values


def _take_with_columns(rows: list[YoloRow], validator: ImportValidator, loose: LooseBoxes) -> None:
    """Take rows with columns after the box: a track id, a confidence, or both."""
    asked = validator.target.switches.get("column6", "auto")
    sixth = [row for row in rows if len(row.rest) == 1]
    kind, why = (asked, "as you said") if asked != "auto" else _what_sixth_is(sixth)
    for row in rows:
        score, track = math.nan, None
        if len(row.rest) == 2:
            score, track = row.rest
        elif row.rest and kind == "confidence":
            score = row.rest[0]
        elif row.rest:
            track = row.rest[0]
        if track is None:
            loose.add(row.frame, row.edges, row.label, file=row.file, line=row.line, score=score)
            continue
        if track != int(track) or not 0 <= track < 1e15:
            raise refuse(row.file, row.line, f"the track id must be a whole number from 0 on. Got {track:g}.")
        validator.box(f"track{int(track)}", row.frame, row.edges, row.label, file=row.file, line=row.line, score=score)
    if sixth:
        first = sixth[0]
        meaning = "confidences" if kind == "confidence" else "track ids"
        validator.repair(
            f"{first.file}, line {first.line}: YOLO has 5 columns; the sixth of {plural(len(sixth), 'row')} was "
            f"taken as {meaning}: {why} (column6)."
        )


def _what_sixth_is(rows: list[YoloRow]) -> tuple[str, str]:
    """Decide over all files between ``track`` and ``confidence``; return it with the reason.

    Raises:
        ImportFormatError: neither is possible.
    """
    whole = all(row.rest[0] == int(row.rest[0]) for row in rows)
    wrong = next((row for row in rows if row.rest[0] < 0 or (row.rest[0] > 1 and not whole)), None)
    if wrong is not None:
        raise refuse(
            wrong.file,
            wrong.line,
            f"the sixth column must be track ids (whole numbers from 0 on) or confidences (0 to 1) in all files. Got "
            f"{wrong.rest[0]:g}. Delete the column.",
        )
    if not whole:
        return "confidence", "some have a fraction and all are in 0 to 1"
    seen = Counter((row.file, row.rest[0]) for row in rows)
    if all(row.rest[0] <= 1 for row in rows) and max(seen.values(), default=0) > 1:
        return "confidence", "all are 0 or 1 and one picture has the same twice"
    return "track", "all are whole numbers"


def _take_with_side(rows: list[YoloRow], path: Path, validator: ImportValidator, loose: LooseBoxes) -> None:
    """Take rows whose tracks the side file names: by their text, else by their line."""
    side: dict[str, list[SideRow]] = {}
    for named in read_side(path, SIDE_OWN):
        side.setdefault(named.own["file"], []).append(named)
    by_file: dict[str, list[YoloRow]] = {}
    for row in rows:
        by_file.setdefault(row.file, []).append(row)
    for file, own in by_file.items():
        for row, entry in _matched(own, side.get(file, []), validator):
            if entry is None:
                validator.count(f"Boxes without a row in {path.name}", row.file, row.line)
                loose.add(row.frame, row.edges, row.label, file=row.file, line=row.line)
                continue
            known = entry.uid in validator
            taken = validator.box(
                entry.uid,
                row.frame,
                row.edges,
                row.label,
                file=row.file,
                line=row.line,
                key=entry.key,
                occluded=entry.occluded,
                ignore=entry.ignore,
                score=entry.score,
                said=entry.said,
            )
            if taken and (entry.note or not known):
                entry.describe(validator, row.frame)


def _matched(
    rows: list[YoloRow], side: list[SideRow], validator: ImportValidator
) -> list[tuple[YoloRow, SideRow | None]]:
    by_text: dict[str, deque[SideRow]] = {}
    for entry in side:
        by_text.setdefault(entry.own["row"], deque()).append(entry)
    out: list[tuple[YoloRow, SideRow | None]] = []
    for row in rows:
        waiting = by_text.get(row.text)
        out.append((row, waiting.popleft() if waiting else None))
    left = [entry for waiting in by_text.values() for entry in waiting]
    changed = [place for place, (_, entry) in enumerate(out) if entry is None]
    # Moved boxes keep their line if none was added or deleted.
    if changed and len(rows) == len(side):
        left.sort(key=lambda entry: entry.line)
        for place, kept in zip(changed, left, strict=True):
            row = out[place][0]
            validator.count("Boxes changed since the export kept the track of their line", row.file, row.line)
            out[place] = (row, kept)
    return out
