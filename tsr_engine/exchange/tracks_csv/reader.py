"""Reads plain CSV of tracks or detections by the names of its columns."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.attributes import parse_attributes
from tsr_engine.exchange.dataset import UNSTATED_LABEL, Dataset, DatasetVideo
from tsr_engine.exchange.file_listing import head_of
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.frame_origin import FrameOrigin
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.linking import UntrackedBoxes
from tsr_engine.exchange.manifest import MANIFEST
from tsr_engine.exchange.nearby_manifest import is_named_after, manifest_value
from tsr_engine.exchange.notes import notes_from_text
from tsr_engine.exchange.reading import rule_error
from tsr_engine.exchange.sidecar import read_header, read_rows
from tsr_engine.exchange.split import SUBSETS
from tsr_engine.exchange.table_columns import (
    MISSING_VALUES,
    PICTURE_COLUMNS,
    Columns,
    class_of_cells,
    find_columns,
    is_id_column,
    normalized,
    with_video,
)
from tsr_engine.exchange.tracks_csv.cells import differ, read_edges, read_flag, read_number, read_score, read_uid
from tsr_engine.exchange.truncated_files import last_byte, report_truncated
from tsr_engine.exchange.video_matching import VideoPart, choose_parts
from tsr_engine.exchange.video_names import safe_stem
from tsr_engine.io.plain_numbers import parse_real
from tsr_engine.json_shapes import JsonObject
from tsr_engine.track_table import NO_CLASS

CLASS_NUMBERS_REPORT = "The class numbers of rows without a class name were taken as the tool's"
_SOURCES = frozenset({"engine", "corrected", "human", "truth", "imported"})
_TEXT_COLUMNS = frozenset({"uid", "note"})
_OPTIONAL_COLUMNS = frozenset({"track", "score", "visibility", "occluded", "ignore", "key"})
"""Cells that may be words for a missing value."""
_NO_SCORE = frozenset({"-1", "-1.0"})
"""MOTChallenge's value for a missing score."""
_MIN_VISIBILITY = 0.5


def files_of_video(path: Path, video: DatasetVideo, suffix: str) -> list[Path]:
    """The files of a folder that are named after a video, also in the folders of a split; else the only file.

    Raises:
        ImportFormatError: there is no file, or the choice is ambiguous.
    """
    if path.is_file():
        return [path]
    files = sorted(file for file in path.rglob(f"*{suffix}") if file.is_file() and file.name != MANIFEST)
    stem = Path(video.name).stem.casefold()
    found = [file for file in files if is_named_after(path, video, file.stem)]
    found = found or [file for file in files if file.stem.casefold() == stem]
    if not found and (len(files) == 1 or len({file.name for file in files}) == 1):
        found = files
    if not found:
        problem = (
            f"has {len(files)} {suffix} files, none called {safe_stem(video.name)}{suffix}"
            if files
            else f"has no {suffix} file"
        )
        raise ImportFormatError(f"{path.name}: {problem}. Import one of them.")
    return found


def name_in(path: Path, file: Path) -> str:
    """The name of a file for messages, within an imported folder or file: the files of a split have the same name."""
    return file.relative_to(path).as_posix() if path.is_dir() else file.name


def read_tracks_csv(path: Path, target: ImportTarget) -> Dataset:
    """Read a file or folder.

    Raises:
        ImportFormatError: a row breaks a rule.
    """
    validator = ImportValidator(target)
    files = files_of_video(path, target.video, ".csv") if path.is_dir() else [path]
    formulas_quoted = manifest_value(path if path.is_dir() else path.parent, "formulas") == "quoted"
    loose = UntrackedBoxes(validator, files[0].name)
    for file in files:
        _Table(file, name_in(path, file), formulas_quoted, validator, loose).read()
    loose.finish()
    return validator.finish(files[0].name)


class _Table:
    """Reads one file."""

    def __init__(
        self, path: Path, name: str, formulas_quoted: bool, validator: ImportValidator, loose: UntrackedBoxes
    ) -> None:
        self._path = path
        # The mark that the header has most of.
        self._delimiter = max(",;\t", key=_first_line(path).count)
        self._name = name
        self._formulas_quoted = formulas_quoted
        self._validator = validator
        self._loose = loose
        self._columns = Columns({}, (), (), False, False)
        self._origin = FrameOrigin(validator)
        self._video: str | None = None

    def read(self) -> None:
        """Take all rows."""
        header_read = False
        for line, cells in read_rows(self._path, (), delimiter=self._delimiter, name=self._name):
            if not header_read:
                header_read = True
                self._columns = self._columns_of(cells)
                if "video" not in self._columns.named:
                    self._columns = with_video(self._columns, cells)
                self._find_video_and_origin()
            if self._video is None or cells[self._columns.named["video"]] == self._video:
                self._add_row(self._named_cells(cells), cells, line)
        if not header_read:
            self._columns_of(dict.fromkeys(read_header(self._path, delimiter=self._delimiter), ""))
        report_truncated([(self._name, last_byte(self._path))], self._validator)

    def _columns_of(self, cells: Mapping[str, str]) -> Columns:
        try:
            columns = find_columns(cells)
        except ValueError as error:
            rule = f"the header has more than one set of box columns: {error}. Keep one."
            raise rule_error(self._name, 1, rule) from None
        if "frame" not in columns.named or not columns.box:
            pictures = [name for name in cells if normalized(name) in PICTURE_COLUMNS]
            if pictures and columns.box:
                rule = f"names pictures ({pictures[0]}), not frames. Add a column frame, or export as COCO."
                raise rule_error(self._name, 1, rule)
            rule = f"the header must have frame and x1,y1,x2,y2 or x,y,w,h. Got {','.join(cells)[:120]}. Add them."
            raise rule_error(self._name, 1, rule)
        return columns

    def _find_video_and_origin(self) -> None:
        """Find the first frame number of the file, and its video."""
        named = self._columns.named
        default = 1 if self._columns.mot else 0 if self._columns.is_own_table else None
        self._origin = FrameOrigin(self._validator, default, is_certain=self._columns.is_own_table)
        if self._origin.decided and "video" not in named:
            return
        videos: dict[str, list[str]] = {}
        for _, cells in read_rows(self._path, (), delimiter=self._delimiter, name=self._name):
            videos.setdefault(cells[named["video"]] if "video" in named else "", []).append(cells[named["frame"]])
        if "video" in named:
            parts = [VideoPart(name, (name.strip(),), ids=(name.strip(),)) for name in videos]
            self._video = choose_parts(parts, self._validator, self._name, "video")[0].content
        if not self._origin.decided:
            for number in videos[self._video or ""]:
                try:
                    self._origin.add(parse_real(number))
                except ValueError:
                    return  # read() refuses the row
            self._origin.decide(self._name)

    def _named_cells(self, cells: Mapping[str, str]) -> dict[str, str]:
        named = {
            name: cells[column] if name in _TEXT_COLUMNS else cells[column].strip()
            for name, column in self._columns.named.items()
        }
        if self._formulas_quoted:
            named = {name: cell.removeprefix("'") for name, cell in named.items()}
        for name in _OPTIONAL_COLUMNS & named.keys():
            if named[name].lower() in MISSING_VALUES:
                named[name] = ""
        if self._columns.mot and named.get("score") in _NO_SCORE:
            named["score"] = ""
        return named

    def _add_row(self, named: Mapping[str, str], cells: Mapping[str, str], line: int) -> None:
        file, validator = self._name, self._validator
        frame = self._origin.frame(named["frame"], file, line)
        for other in self._columns.frames:
            if differ(cells[other], named["frame"]):
                first, second = self._columns.named["frame"], cells[other].strip()[:40]
                rule = f"{first} says {named['frame'][:40]} and {other} {second}. Keep one of the columns."
                raise rule_error(file, line, rule)
        if "w" not in named:
            self._check_size(cells, line)
        edges = validator.boxes.edges(lambda: read_edges(named, self._columns.is_own_table, file, line))
        visibility = read_number(named, "visibility", file, line) if named.get("visibility") else 1.0
        if not -1 <= visibility <= 1:
            raise rule_error(file, line, f"visibility must be in 0 to 1. Got {named['visibility'][:40]!r}.")
        box_fields: JsonObject = {
            "file": file,
            "line": line,
            "key": read_flag(named, "key", file, line, True),
            "occluded": read_flag(named, "occluded", file, line, 0 <= visibility < _MIN_VISIBILITY),
            "ignore": read_flag(named, "ignore", file, line, False),
            "score": read_score(named, file, line),
            "attributes": parse_attributes(named.get("attributes"), file, line),
        }
        label = self._label(cells, line)
        uid = read_uid(named, file, line)
        if not uid:
            self._loose.add(frame, edges, label, **box_fields)
            return
        is_known = uid in validator
        taken = validator.box(uid, frame, edges, label, **box_fields)
        note = named.get("note", "")
        if taken and (note or not is_known):
            source = named.get("source", "")
            validator.describe(
                uid,
                state=named.get("state") or "open",
                source=source if source in _SOURCES else "imported",
                notes=notes_from_text(note, frame),
            )

    def _check_size(self, cells: Mapping[str, str], line: int) -> None:
        """Report a picture size that differs from the video's, in tables that state it beside corners."""
        video = self._validator.target.video
        size = (cells.get("width", ""), cells.get("height", ""))
        with suppress(ValueError):
            if all(size) and tuple(map(parse_real, size)) != (video.width, video.height):
                what = f"Rows are about pictures of {size[0][:12]}x{size[1][:12]} px"
                report = f"{what}, {video.name} has {video.width}x{video.height}; their boxes were not scaled"
                self._validator.count(report, self._name, line)

    def _label(self, cells: Mapping[str, str], line: int) -> int:
        columns = self._columns
        given = {column: cells[column].strip() for column in columns.classes}
        if self._formulas_quoted:
            given = {column: each.removeprefix("'") for column, each in given.items()}
        cell = class_of_cells(given.values())
        if not cell:
            return UNSTATED_LABEL
        try:
            number = parse_real(cell)
        except ValueError:
            return self._validator.label(cell, self._name, line)
        if number == NO_CLASS:
            return NO_CLASS
        if not any(is_id_column(column) for column, each in given.items() if each == cell):
            return self._validator.label(cell, self._name, line)
        if not math.isfinite(number) or number != int(number):
            raise rule_error(self._name, line, f"class_id must be a whole number. Got {cell[:40]!r}.")
        name = str(int(number))
        if not columns.is_own_table and name not in self._validator.target.label_map:
            self._validator.count(CLASS_NUMBERS_REPORT, self._name, line)
        return self._validator.label(name, self._name, line, number=True)


def _first_line(path: Path) -> str:
    return head_of(path, 1 << 12).partition(b"\n")[0].decode("utf-8-sig", "replace")


def sniff_tracks_csv(path: Path) -> bool:
    """Whether the path is, or holds, a CSV with a header of frames and boxes."""
    files = [path]
    if path.is_dir():
        # Deeper folders are checked separately.
        files = sorted([*path.glob("*.csv"), *(f for subset in SUBSETS for f in path.glob(f"{subset}/*.csv"))])[:20]
    for file in files:
        if file.suffix.lower() not in (".csv", ".tsv", ".txt"):
            continue
        header = re.split("[,;\t]", _first_line(file))
        names = {normalized(cell.strip().strip('"')) for cell in header}
        try:
            columns = find_columns(names)
        except ValueError:
            return True
        # A table without frames counts, because the reader's message says best what is missing.
        if columns.box and ("frame" in columns.named or (columns.classes and names & {*PICTURE_COLUMNS, "confidence"})):
            return True
    return False
