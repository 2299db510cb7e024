"""Reads plain CSV of tracks or detections by the names of its columns."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.beside import is_called, told_by_manifest
from tsr_engine.exchange.checks import Intake, refuse
from tsr_engine.exchange.dataset import NONE, UNSAID, Dataset, DatasetVideo
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.linking import LooseBoxes
from tsr_engine.exchange.manifest import MANIFEST
from tsr_engine.exchange.names import safe_stem
from tsr_engine.exchange.notes import notes_from_text
from tsr_engine.exchange.sidecar import read_rows
from tsr_engine.exchange.split import SUBSETS
from tsr_engine.io.plain_numbers import real_number
from tsr_engine.records import Source

__all__ = ["own_files", "read_tracks_csv", "sniff_tracks_csv"]

_NAMES: dict[str, tuple[str, ...]] = {
    "frame": ("frame", "frame_id", "frame_number"),
    "track": ("track_id", "track", "id", "object_id"),
    "uid": ("uid",),
    "x1": ("x1", "xmin", "left", "xtl"),
    "y1": ("y1", "ymin", "top", "ytl"),
    "x2": ("x2", "xmax", "right", "xbr"),
    "y2": ("y2", "ymax", "bottom", "ybr"),
    "class": ("class_id", "category_id"),
    "label": ("label", "class", "class_name", "category"),
    "score": ("score", "confidence", "conf"),
    "source": ("source",),
    "visibility": ("visibility",),
    "occluded": ("occluded",),
    "ignore": ("ignore",),
    "key": ("key", "keyframe"),
    "state": ("state",),
    "note": ("note",),
}
_MOT = ("bb_left", "bb_top", "bb_width", "bb_height")
"""As MOTChallenge calls them; its ``x,y,z`` beside them are positions in space."""
_SIZED = (("x", "y", "w", "h"), ("left", "top", "width", "height"))
"""Names that belong together."""
_CORNERS = (("x", "y"), ("bb_left", "bb_top"), *zip(_NAMES["x1"], _NAMES["y1"], strict=True))
_SIZES = (("w", "h"), ("width", "height"), ("bb_width", "bb_height"))
_SOURCES = frozenset({"engine", "corrected", "human", "truth", "imported"})
_LOG_ODDS = frozenset(get_args(Source))
"""What a row of ``tsr track --csv`` may have as its source."""
_TEXT = frozenset({"uid", "note"})
_NO_SCORE = frozenset({"-1", "-1.0"})
"""As MOTChallenge says that there is none."""
_OCCLUDED = 0.5


def own_files(path: Path, video: DatasetVideo, suffix: str) -> list[Path]:
    """The files of a folder that are about a video: named after it, also in the folders of a split; else the only one.

    Raises:
        ImportFormatError: there is none, or it is not clear which.
    """
    if path.is_file():
        return [path]
    inside = sorted(file for file in path.rglob(f"*{suffix}") if file.is_file() and file.name != MANIFEST)
    own = Path(video.name).stem.casefold()
    found = [file for file in inside if is_called(path, video, file.stem)]
    found = found or [file for file in inside if file.stem.casefold() == own]
    if not found and (len(inside) == 1 or len({file.name for file in inside}) == 1):
        found = inside
    if not found:
        what = (
            f"has {len(inside)} {suffix} files, none called {safe_stem(video.name)}{suffix}"
            if inside
            else f"has no {suffix} file"
        )
        raise ImportFormatError(f"{path.name}: {what}. Import one of them.")
    return found


def read_tracks_csv(path: Path, target: ImportTarget) -> Dataset:
    """Read a file or folder.

    Raises:
        ImportFormatError: a broken rule.
    """
    intake = Intake(target)
    files = own_files(path, target.video, ".csv") if path.is_dir() else [path]
    guarded = told_by_manifest(path if path.is_dir() else path.parent, "formulas") == "quoted"
    said_origin = target.switches.get("first_frame", "auto")
    loose = LooseBoxes(intake, files[0].name)
    for file in files:
        columns: dict[str, str] | None = None
        mot, origin = False, 0
        for line, cells in read_rows(file, (), delimiter=_delimiter(file)):
            if columns is None:
                columns = _columns(cells, file.name)
                mot = columns.get("x") == _MOT[0]
                origin = int(mot) if said_origin == "auto" else int(said_origin)
            said = {name: cells[column] if name in _TEXT else cells[column].strip() for name, column in columns.items()}
            if guarded:
                said = {name: cell.removeprefix("'") for name, cell in said.items()}
            if mot and said.get("score") in _NO_SCORE:
                said["score"] = ""
            _take(said, file.name, line, origin, intake, loose)
    loose.settle()
    return intake.finish(files[0].name)


def _delimiter(path: Path) -> str:
    with path.open("rb") as stream:
        start = stream.readline(1 << 12)
    return max((",", ";", "\t"), key=lambda mark: start.count(mark.encode()))


def _columns(cells: Mapping[str, str], file: str) -> dict[str, str]:
    """Meaning -> column."""
    found: dict[str, str] = {}
    for name, known in _NAMES.items():
        column = next((column for column in known if column in cells), None)
        if column is not None:
            found[name] = column
    edges = {"x1", "y1", "x2", "y2"} <= set(found)
    sized: tuple[str, ...] | None = _MOT if cells.keys() >= set(_MOT) else None
    if sized is None and not edges:
        sized = _sized(cells, file)
    if "frame" not in found or not (edges or sized):
        raise refuse(
            file, 1, f"the header must have frame and x1,y1,x2,y2 or x,y,w,h. Got {','.join(cells)[:120]}. Add them."
        )
    if sized is not None:
        for name in ("x1", "y1", "x2", "y2"):
            found.pop(name, None)
        found.update(zip("xywh", sized, strict=True))
    return found


def _sized(cells: Mapping[str, str], file: str) -> tuple[str, ...] | None:
    """The columns of a corner, a width and a height that belong together; None: there are none."""
    alike = [names for names in _SIZED if cells.keys() >= set(names)]
    found = alike or [(*corner, *size) for corner in _CORNERS for size in _SIZES if cells.keys() >= {*corner, *size}]
    if len(found) > 1:
        sets = " or ".join(",".join(names) for names in found[:3])
        raise refuse(file, 1, f"the header has more than one set of box columns: {sets}. Keep one.")
    return found[0] if found else None


def _take(said: Mapping[str, str], file: str, line: int, origin: int, intake: Intake, loose: LooseBoxes) -> None:
    frame = intake.frame(said["frame"], file, line, origin=origin)
    edges = intake.edges(lambda: _edges(said, file, line))
    visibility = _real(said, "visibility", file, line) if said.get("visibility") else 1.0
    if not -1 <= visibility <= 1:
        raise refuse(file, line, f"visibility must be in 0 to 1. Got {said['visibility'][:40]!r}.")
    given: dict[str, Any] = {
        "file": file,
        "line": line,
        "key": _flag(said, "key", file, line, True),
        "occluded": _flag(said, "occluded", file, line, 0 <= visibility < _OCCLUDED),
        "ignore": _flag(said, "ignore", file, line, False),
        "score": _score(said, file, line),
    }
    label = _label(said, file, line, intake)
    uid = _uid(said, file, line)
    if not uid:
        loose.add(frame, edges, label, **given)
        return
    known = uid in intake
    taken = intake.box(uid, frame, edges, label, **given)
    note = said.get("note", "")
    if taken and (note or not known):
        source = said.get("source", "")
        intake.describe(
            uid,
            state=said.get("state") or "open",
            source=source if source in _SOURCES else "imported",
            notes=notes_from_text(note, frame),
        )


def _edges(said: Mapping[str, str], file: str, line: int) -> tuple[float, float, float, float]:
    if "x1" in said:
        x1, y1, x2, y2 = (_real(said, name, file, line) for name in ("x1", "y1", "x2", "y2"))
        return x1, y1, x2, y2
    x, y, w, h = (_real(said, name, file, line) for name in ("x", "y", "w", "h"))
    return x, y, x + w, y + h


def _uid(said: Mapping[str, str], file: str, line: int) -> str:
    """Name of the track; empty: none."""
    if said.get("uid"):
        return said["uid"]
    cell = said.get("track", "")
    try:
        number = real_number(cell) if cell else -1.0
    except ValueError:
        return cell
    if not math.isfinite(number) or number != int(number):
        raise refuse(file, line, f"track_id must be a whole number or a name. Got {cell[:40]!r}.")
    return str(int(number)) if number >= 0 else ""


def _label(said: Mapping[str, str], file: str, line: int, intake: Intake) -> int:
    if said.get("label"):
        return intake.label(said["label"], file, line)
    cell = said.get("class", "")
    if not cell:
        return UNSAID
    try:
        number = real_number(cell)
    except ValueError:
        return intake.label(cell, file, line)
    if not math.isfinite(number) or number != int(number):
        raise refuse(file, line, f"class_id must be a whole number. Got {cell[:40]!r}.")
    return NONE if number == NONE else intake.label(str(int(number)), file, line)


def _score(said: Mapping[str, str], file: str, line: int) -> float:
    """In [0, 1], NaN where there is none. The table of `tsr track`, known by its sources, has log-odds."""
    if not said.get("score"):
        return math.nan
    value = _real(said, "score", file, line)
    if said.get("source") in _LOG_ODDS:
        return 1.0 / (1.0 + math.exp(-min(max(value, -500.0), 500.0)))
    return value


def _flag(said: Mapping[str, str], name: str, file: str, line: int, default: bool) -> bool:
    cell = said.get(name, "").lower()
    if not cell:
        return default
    if cell not in ("0", "1", "true", "false", "0.0", "1.0"):
        raise refuse(file, line, f"{name} must be 0 or 1. Got {cell[:40]!r}.")
    return cell in ("1", "true", "1.0")


def _real(said: Mapping[str, str], name: str, file: str, line: int) -> float:
    cell = said[name]
    try:
        value = real_number(cell)
    except ValueError:
        raise refuse(file, line, f"{name} must be a number. Got {cell[:40]!r}.") from None
    if not math.isfinite(value):
        raise refuse(file, line, f"{name} must be finite. Got {cell[:40]!r}. Correct it.")
    return value


def sniff_tracks_csv(path: Path) -> bool:
    """Whether it is, or has, a CSV with a header of frames and boxes."""
    files = [path]
    if path.is_dir():
        # Deeper folders are looked at on their own.
        files = sorted([*path.glob("*.csv"), *(f for side in SUBSETS for f in path.glob(f"{side}/*.csv"))])[:20]
    for file in files:
        if file.suffix.lower() not in (".csv", ".tsv", ".txt"):
            continue
        with file.open("rb") as stream:
            start = stream.readline(1 << 12)
        names = {
            cell.strip().lower()
            for cell in start.decode("utf-8-sig", "replace").replace(";", ",").replace("\t", ",").split(",")
        }
        if names & set(_NAMES["frame"]) and names & {corner[0] for corner in _CORNERS}:
            return True
    return False
