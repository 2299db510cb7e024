"""GTSDB's ``gt.txt``: ``file;left;top;right;bottom;class``, whole pixels, one row a sign, no header.

The benchmark does not say whether right and bottom belong to the sign. On its pictures the inclusive reading fits
(``tsr_engine.io.gtsdb``), so it is what is written unless the switch ``corners`` says otherwise; the manifest tells.
Pictures without signs have no row, so ``pictures.txt`` lists all pictures.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tsr_engine.counted import counted
from tsr_engine.exchange.beside import is_wrapper, stated_by_manifest
from tsr_engine.exchange.checks import ImportValidator, read_text, refuse
from tsr_engine.exchange.counting import Custom
from tsr_engine.exchange.dataset import Dataset, Skipped
from tsr_engine.exchange.formats import ExportOptions, Format, ImportTarget, Switch
from tsr_engine.exchange.labels import benchmark_keys, benchmark_numbers
from tsr_engine.exchange.line_ends import last_of, tell_open_ends
from tsr_engine.exchange.linking import LINK_SWITCH, LooseBoxes
from tsr_engine.exchange.output_sink import OutputSink
from tsr_engine.exchange.picture_lists import IMAGE_SWITCH, PictureList, picture_lists, subsets_in, write_files
from tsr_engine.exchange.picture_rows import PICTURE_SWITCHES, Listed, names_in
from tsr_engine.exchange.whole_pixels import whole_pixels
from tsr_engine.exchange.whose_pictures import frames_of_pictures
from tsr_engine.io.plain_numbers import whole_number

__all__ = ["FORMAT"]

TRUTH = "gt.txt"
LIST = "pictures.txt"
_BENCHMARK = Custom(0, "the benchmark's scenes begin with 00000", before="", digits=5)


def _write(dataset: Dataset, out: OutputSink, options: ExportOptions) -> tuple[list[Skipped], dict[str, Any]]:
    suffix = options.switches.get("image", "jpg")
    corners = options.switches.get("corners", "inclusive")
    numbers = benchmark_numbers(dataset.labels)
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
                        elif label not in numbers:
                            unknown += 1
                        else:
                            truth.write(f"{name};{';'.join(map(str, edges[k]))};{numbers[label]}\n")
                    done += 1
                    options.progress(done, total)
    pictures = write_files(
        lists,
        out,
        options,
        lambda part, frame, subset: (f"{subset}/" if options.split else "") + _name(part, frame, suffix),
    )
    skipped = [Skipped(f"{ignored} boxes to ignore", "gt.txt has no such mark.")] if ignored else []
    why = "Their label is none of the 43 classes that gt.txt has numbers for."
    skipped += [Skipped(counted(unknown, "box", "boxes"), why)] if unknown else []
    what = "right and bottom are the last pixels of the sign" if corners == "inclusive" else "right, bottom are edges"
    return skipped, {"origin": 0, "corners": corners, "meaning": what, "pictures": pictures}


def _name(part: PictureList, frame: int, suffix: str) -> str:
    """As in the benchmark, ``00010.ppm``; with several videos, after the name of each."""
    return f"{part.stem(frame) if part.prefix else f'{frame:05d}'}.{suffix}"


def _read(path: Path, target: ImportTarget) -> Dataset:
    validator = ImportValidator(target)
    files = _files(path)
    if not files:
        raise refuse(path.name, None, f"has no {TRUTH}. Name the folder that has it.")
    home = path if path.is_dir() else path.parent
    corners = target.switches.get("corners", "auto")
    if corners == "auto":
        corners = stated_by_manifest(home, "corners") or "inclusive"
    rows = [
        (file.relative_to(home).as_posix(), line, content)
        for file in files
        for line, content in enumerate(read_text(file).splitlines(), start=1)
        if content.strip()
    ]
    tell_open_ends(((file.relative_to(home).as_posix(), last_of(file)) for file in files), validator)
    listed: dict[tuple[str, str], Listed] = {}
    for name, line, content in rows:
        picture = _cells(content, name, line)[0]
        if (name, picture) not in listed:
            listed[name, picture] = Listed(picture, name, line, custom=_BENCHMARK)
    more = [picture for file in files for picture in names_in(file.parent / LIST)]
    frames = dict(zip(listed, frames_of_pictures(list(listed.values()), validator, home, more), strict=True))
    loose = LooseBoxes(validator, files[0].name)
    for name, line, content in rows:
        cells = _cells(content, name, line)
        frame = frames[name, cells[0]]
        if frame is not None:
            _read_row(cells, frame, name, line, corners, validator, loose)
    loose.settle()
    return validator.finish(files[0].name)


def _cells(content: str, file: str, line: int) -> list[str]:
    cells = [cell.strip() for cell in content.split(";")]
    if len(cells) != 6:
        raise refuse(file, line, f"must be file;left;top;right;bottom;class. Got {content.strip()[:60]!r}.")
    return cells


def _read_row(
    cells: list[str], frame: int, file: str, line: int, corners: str, validator: ImportValidator, loose: LooseBoxes
) -> None:
    label = _whole(cells[5], cells, file, line)
    if not 0 <= label < len(benchmark_keys()):
        raise refuse(file, line, f"class {label} must be 0 to {len(benchmark_keys()) - 1}. Correct it.")
    edges = validator.edges(lambda: _edges(cells, 1 if corners == "inclusive" else 0, file, line))
    loose.add(frame, edges, validator.label(benchmark_keys()[label], file, line), file=file, line=line)


def _edges(cells: list[str], extra: int, file: str, line: int) -> tuple[float, float, float, float]:
    left, top, right, bottom = (_whole(cell, cells, file, line) for cell in cells[1:5])
    if min(left, top) < 0 or max(left, top, right, bottom) > 1_000_000:
        raise refuse(file, line, f"corners must be pixels from 0. Got {left};{top};{right};{bottom}.")
    return left, top, right + extra, bottom + extra


def _whole(cell: str, cells: list[str], file: str, line: int) -> int:
    try:
        return whole_number(cell)
    except ValueError:
        raise refuse(file, line, f"must have whole numbers after the file. Got {';'.join(cells)[:60]!r}.") from None


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
        *PICTURE_SWITCHES,
        LINK_SWITCH,
    ),
    attributes="none",
    ignores=False,
    docs="gtsdb.md",
)
