"""Reads GTSRB class folders with a ``crops.csv``, which says where each crop was cut out of its video."""

from __future__ import annotations

from pathlib import Path

from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.labels import benchmark_keys
from tsr_engine.exchange.nearby_manifest import is_wrapper
from tsr_engine.exchange.reading import read_text, rule_error
from tsr_engine.exchange.sidecar import read_sidecar
from tsr_engine.exchange.truncated_files import last_byte, report_truncated
from tsr_engine.exchange.video_matching import VideoPart, choose_parts
from tsr_engine.io.gtsrb import table_rows
from tsr_engine.io.plain_numbers import parse_whole
from tsr_engine.plural import plural

SIDECAR = "crops.csv"
SIDECAR_COLUMNS = ("file", "video", "video_sha256", "frame", "left", "top", "picture_sha256")
_NUMBER_COLUMNS = ("Roi.X1", "Roi.Y1", "Roi.X2", "Roi.Y2", "ClassId")


def read_crops(path: Path, target: ImportTarget) -> Dataset:
    """Read a folder of class folders.

    Raises:
        ImportFormatError: the folder breaks a rule, or does not say where the crops were cut out.
    """
    root = path if path.is_dir() else path.parent
    if not (root / SIDECAR).is_file():
        raise rule_error(
            path.name,
            None,
            f"has no {SIDECAR}: crops alone do not say where in the video they were cut out. Use them for training, or "
            "export from this tool again.",
        )
    tables: dict[str, tuple[str, int, tuple[int, ...]]] = {}
    table_files = sorted(root.rglob("GT-*.csv"))
    for table in table_files:
        _read_table(table, root, tables)
    validator = ImportValidator(target)
    video = target.video
    sidecar_rows = list(read_sidecar(root / SIDECAR, SIDECAR_COLUMNS))
    names = {(entry.format_cells["video"], entry.format_cells["video_sha256"]): None for entry in sidecar_rows}
    parts = [
        VideoPart(key, (key[0],), ids=(key[0],), is_match=key[1] == video.sha256 if key[1] and video.sha256 else None)
        for key in names
    ]
    videos = {part.content for part in choose_parts(parts, validator, SIDECAR, "video", merge=True)}
    files = (root / SIDECAR, *table_files)
    report_truncated(((file.relative_to(root).as_posix(), last_byte(file)) for file in files), validator)
    others = missing = 0
    for entry in sidecar_rows:
        if (entry.format_cells["video"], entry.format_cells["video_sha256"]) not in videos:
            others += 1
            continue
        found = tables.pop(entry.format_cells["file"], None)
        if found is None:
            missing += 1
            continue
        file, line, (x1, y1, x2, y2, label) = found
        if not 0 <= label < len(benchmark_keys()):
            raise rule_error(file, line, f"class {label} must be 0 to {len(benchmark_keys()) - 1}. Correct it.")
        frame = validator.frame(entry.format_cells["frame"], SIDECAR, entry.line)
        left, top = (_whole(entry.format_cells[name], name, SIDECAR, entry.line) for name in ("left", "top"))
        edges = (left + x1, top + y1, left + x2, top + y2)
        entry.add(validator, frame, edges, validator.label(benchmark_keys()[label], file, line), file, line)
    if others:
        validator.skip(plural(others, "crop"), f"They are from another video than {video.name}.")
    if missing:
        validator.skip(f"{plural(missing, 'crop')} of {SIDECAR}", "No table GT-*.csv lists them.")
    if len(names) == 1 and tables:
        validator.skip(plural(len(tables), "crop"), f"{SIDECAR} does not say where they were cut out.")
    return validator.finish(SIDECAR)


def _read_table(table: Path, root: Path, out: dict[str, tuple[str, int, tuple[int, ...]]]) -> None:
    name = table.relative_to(root).as_posix()
    for line, row in table_rows(read_text(table), lambda line, rule: rule_error(name, line, rule)):
        numbers = tuple(_whole(row.get(column, ""), column, name, line) for column in _NUMBER_COLUMNS)
        picture = row.get("Path") or row.get("Filename", "")
        file = (table.parent.relative_to(root) / picture.lstrip("/")).as_posix()
        if file in out:
            raise rule_error(name, line, f"{picture[:60]} occurs twice. Delete one of the lines.")
        out[file] = (name, line, numbers)


def _whole(cell: str, name: str, file: str, line: int) -> int:
    try:
        value = parse_whole(cell)
    except ValueError:
        raise rule_error(file, line, f"{name} must be a whole number. Got {cell[:40]!r}.") from None
    if abs(value) > 1_000_000:
        raise rule_error(file, line, f"{name} must be within 1000000. Got {cell[:40]!r}.")
    return value


def sniff_crops(path: Path) -> bool:
    """Whether a folder has class folders with tables, or the list of crops."""
    if not path.is_dir() or (is_wrapper(path) and not any(path.glob("[0-9]*/GT-*.csv"))):
        return False
    return (path / SIDECAR).is_file() or any(path.glob("[0-9]*/GT-*.csv")) or any(path.glob("*/[0-9]*/GT-*.csv"))
