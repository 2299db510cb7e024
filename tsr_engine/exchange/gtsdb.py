"""GTSDB's ``gt.txt``: ``file;left;top;right;bottom;class``, whole pixels, one row a sign, no header.

The benchmark does not say whether right and bottom belong to the sign. On its pictures the inclusive reading fits
(``tsr_engine.io.gtsdb``), so it is what is written unless the switch ``corners`` says otherwise; the manifest tells.
Pictures without signs have no row, so ``pictures.txt`` lists all pictures.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tsr_engine.exchange.beside import is_wrapper, told_by_manifest
from tsr_engine.exchange.checks import Intake, read_text, refuse
from tsr_engine.exchange.dataset import Dataset, Skipped
from tsr_engine.exchange.formats import ExportOptions, Format, ImportTarget, Switch
from tsr_engine.exchange.linking import LINK_SWITCH, LooseBoxes
from tsr_engine.exchange.outlet import Outlet
from tsr_engine.exchange.picture_lists import (
    IMAGE_SWITCH,
    PictureList,
    PictureNames,
    picture_lists,
    subsets_in,
    write_files,
)
from tsr_engine.exchange.whole_pixels import whole_pixels
from tsr_engine.io.plain_numbers import whole_number

__all__ = ["FORMAT"]

TRUTH = "gt.txt"
LIST = "pictures.txt"


def _write(dataset: Dataset, out: Outlet, options: ExportOptions) -> tuple[list[Skipped], dict[str, Any]]:
    suffix = options.switches.get("image", "jpg")
    corners = options.switches.get("corners", "inclusive")
    lists = picture_lists(dataset, options)
    total = sum(len(part.frames) for part in lists)
    done = ignored = unknown = 0
    for subset in subsets_in(lists, options):
        home = f"{subset}/" if options.split else ""
        with out.text(home + TRUTH, encoding="ascii") as truth, out.text(home + LIST, encoding="ascii") as listed:
            for part in lists:
                rows = part.rows
                boxes = whole_pixels(rows.boxes, part.video.width, part.video.height)
                if corners == "inclusive":
                    boxes[:, 2:] -= 1
                edges = boxes.tolist()
                for frame, at in part.listed(subset):
                    name = _name(part, frame, suffix)
                    listed.write(f"{name}\n")
                    for k in range(at.start, at.stop):
                        label = int(rows.label[k])
                        if rows.ignore[k]:
                            ignored += 1
                        elif label < 0:
                            unknown += 1
                        else:
                            truth.write(f"{name};{';'.join(map(str, edges[k]))};{label}\n")
                    done += 1
                    options.progress(done, total)
    pictures = write_files(
        lists,
        out,
        options,
        lambda part, frame, subset: (f"{subset}/" if options.split else "") + _name(part, frame, suffix),
    )
    skipped = [Skipped(f"{ignored} boxes to ignore", "gt.txt has no such mark.")] if ignored else []
    skipped += [Skipped(f"{unknown} boxes without class", "gt.txt must have a class number.")] if unknown else []
    what = "right and bottom are the last pixels of the sign" if corners == "inclusive" else "right, bottom are edges"
    return skipped, {"origin": 0, "corners": corners, "meaning": what, "pictures": pictures}


def _name(part: PictureList, frame: int, suffix: str) -> str:
    """As in the benchmark, ``00010.ppm``; with several videos, after the name of each."""
    return f"{part.stem(frame) if part.prefix else f'{frame:05d}'}.{suffix}"


def _read(path: Path, target: ImportTarget) -> Dataset:
    intake = Intake(target)
    files = _files(path)
    if not files:
        raise refuse(path.name, None, f"has no {TRUTH}. Name the folder that has it.")
    home = path if path.is_dir() else path.parent
    corners = target.switches.get("corners", "auto")
    if corners == "auto":
        corners = told_by_manifest(home, "corners") or "inclusive"
    pictures = PictureNames(home, target.video)
    loose = LooseBoxes(intake, files[0].name)
    for file in files:
        name = file.relative_to(home).as_posix()
        for line, content in enumerate(read_text(file).splitlines(), start=1):
            if content.strip():
                _read_row(content, name, line, corners, pictures, intake, loose)
    if pictures.others:
        intake.skip(f"{pictures.others} boxes", f"Their pictures are of another video than {target.video.name}.")
    loose.settle()
    return intake.finish(files[0].name)


def _read_row(
    content: str, file: str, line: int, corners: str, pictures: PictureNames, intake: Intake, loose: LooseBoxes
) -> None:
    cells = [cell.strip() for cell in content.split(";")]
    if len(cells) != 6:
        raise refuse(file, line, f"must be file;left;top;right;bottom;class. Got {content.strip()[:60]!r}.")
    frame = pictures.frame(cells[0])
    if frame is None:
        if pictures.is_other(cells[0]):
            return
        raise refuse(file, line, f"the picture {cells[0][:60]!r} has no frame number. Call it 00010.ppm.")
    label = _whole(cells[5], content, file, line)
    if not 0 <= label < len(intake.target.labels):
        raise refuse(file, line, f"class {label} must be 0 to {len(intake.target.labels) - 1}. Correct it.")
    ordinal = intake.frame(frame, file, line)
    edges = intake.edges(lambda: _edges(cells, content, 1 if corners == "inclusive" else 0, file, line))
    loose.add(ordinal, edges, label, file=file, line=line)


def _edges(cells: list[str], content: str, extra: int, file: str, line: int) -> tuple[float, float, float, float]:
    left, top, right, bottom = (_whole(cell, content, file, line) for cell in cells[1:5])
    if min(left, top) < 0 or max(left, top, right, bottom) > 1_000_000:
        raise refuse(file, line, f"corners must be pixels from 0. Got {left};{top};{right};{bottom}.")
    return left, top, right + extra, bottom + extra


def _whole(cell: str, content: str, file: str, line: int) -> int:
    try:
        return whole_number(cell)
    except ValueError:
        raise refuse(file, line, f"must have whole numbers after the file. Got {content.strip()[:60]!r}.") from None


def _files(path: Path) -> list[Path]:
    if path.is_file():
        return [path]
    if (path / TRUTH).is_file():
        return [path / TRUTH]
    return sorted(path.glob(f"*/{TRUTH}"))


def _sniff(path: Path) -> bool:
    if is_wrapper(path):
        return False
    for file in _files(path)[:1] if path.is_dir() or path.suffix.lower() in (".txt", ".csv") else []:
        with file.open("rb") as stream:
            start = stream.read(1 << 12).decode("latin-1")
        line = next((part for part in start.splitlines() if part.strip()), "")
        return line.count(";") == 5 and "Roi" not in line if line else (file.parent / LIST).is_file()
    return False


FORMAT = Format(
    name="gtsdb",
    title="GTSDB gt.txt",
    summary="One line a sign in whole pixels, as the German detection benchmark has it; without tracks.",
    write=_write,
    read=_read,
    sniff=_sniff,
    export_switches=(
        Switch("corners", ("inclusive", "exclusive"), "Right and bottom: the last pixels of the sign, or its edges."),
        Switch("image", ("jpg", "png", "ppm"), IMAGE_SWITCH.help),
    ),
    import_switches=(
        Switch("corners", ("auto", "inclusive", "exclusive"), "As for export; auto: by the manifest, else inclusive."),
        LINK_SWITCH,
    ),
    docs="gtsdb.md",
)
