"""Writes label files, ``data.yaml`` and ``tracks.csv``."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tsr_engine.exchange.dataset import Dataset, Skipped
from tsr_engine.exchange.formats import ExportOptions, Format, Switch, Written
from tsr_engine.exchange.labels import ClassMap, class_map
from tsr_engine.exchange.linking import LINK_SWITCH
from tsr_engine.exchange.nearby_manifest import is_wrapper
from tsr_engine.exchange.output_sink import OutputSink
from tsr_engine.exchange.picture_lists import PictureList, make_picture_lists, write_listed_pictures
from tsr_engine.exchange.picture_sequences import PICTURE_SWITCHES
from tsr_engine.exchange.sidecar import ATTRIBUTES_COLUMN, TRACK_COLUMNS, SidecarCells, csv_line
from tsr_engine.exchange.split import names_of_subsets
from tsr_engine.exchange.yolo.class_names import quoted_name
from tsr_engine.exchange.yolo.reader import SIDECAR, SIDECAR_COLUMNS, YAML_FILES, is_label_file, label_files, read_yolo
from tsr_engine.plural import plural

_DECIMALS = 8


def _write(dataset: Dataset, out: OutputSink, options: ExportOptions) -> Written:
    labels = class_map(dataset, options.used_labels)
    suffix = options.switches.get("image", "jpg")
    with_ignored = options.switches.get("ignored", "leave-out") == "box"
    lists = make_picture_lists(dataset, options)
    subsets = names_of_subsets(options.split) if options.split else ["train"]
    total = sum(len(part.frames) for part in lists)
    done = left_out = 0
    with out.text(SIDECAR, errors="replace") as sidecar:
        sidecar.write(csv_line([*SIDECAR_COLUMNS, *TRACK_COLUMNS, ATTRIBUTES_COLUMN]) + "\n")
        for subset in subsets:
            for part in lists:
                lines = _lines(part, labels)
                track_cells = SidecarCells(part.rows)
                ignore = [False] * len(part.rows.table) if with_ignored else part.rows.table.ignore.tolist()
                for frame, row_range in part.frames_and_rows(subset if options.split else "default"):
                    chosen = [k for k in range(row_range.start, row_range.stop) if not ignore[k]]
                    left_out += row_range.stop - row_range.start - len(chosen)
                    name = f"labels/{subset}/{part.stem(frame)}.txt"
                    out.put(name, "".join(lines[k] for k in chosen).encode("ascii"))
                    for line, k in enumerate(chosen, start=1):
                        sidecar.write(f"{name},{line},{lines[k][:-1]},{track_cells(k)}\n")
                    done += 1
                    options.progress(done, total)
    _write_yaml(out, subsets, labels.names)
    pictures = write_listed_pictures(
        lists,
        out,
        options,
        lambda part, frame, subset: f"images/{subset if options.split else 'train'}/{part.stem(frame)}.{suffix}",
    )
    reason = "YOLO has no such mark; these regions count as background."
    skipped = [Skipped(plural(left_out, "box", "boxes") + " to ignore", reason)] if left_out else []
    return skipped, {"origin": 0, "decimals": _DECIMALS, "columns": 5, "tracks": SIDECAR, "pictures": pictures}


def _write_yaml(out: OutputSink, subsets: list[str], labels: list[str]) -> None:
    """Write no ``path``: Ultralytics then starts at the file's folder; a dot would be the current folder."""
    val = "val" if "val" in subsets else subsets[-1]
    lines = [f"train: images/{'train' if 'train' in subsets else subsets[0]}\n"]
    if val == "train":
        lines.append("# Not split: val lists the training pictures.\n")
    lines.append(f"val: images/{val}\n")
    if "test" in subsets:
        lines.append("test: images/test\n")
    lines.append("names:\n")
    lines += [f"  {index}: {quoted_name(name)}\n" for index, name in enumerate(labels)]
    out.put("data.yaml", "".join(lines).encode())


def _lines(part: PictureList, labels: ClassMap) -> list[str]:
    """The line of each row, with its end."""
    rows, video = part.rows, part.video
    size = np.array([video.width, video.height], dtype=np.float64)
    low, high = rows.table.boxes[:, :2] / size, rows.table.boxes[:, 2:] / size
    # A side that would be written as 0 is not a box to any reader.
    sides = np.maximum(high - low, 10.0**-_DECIMALS)
    values = np.concatenate([(low + high) / 2, sides], axis=1).tolist()
    return [
        f"{labels.index(label)} {cx:.8f} {cy:.8f} {w:.8f} {h:.8f}\n"
        for label, (cx, cy, w, h) in zip(rows.table.class_id.tolist(), values, strict=True)
    ]


def _sniff(path: Path) -> bool:
    if path.is_file() or (is_wrapper(path) and not (path / "labels").is_dir()):
        return False
    names = any((path / name).is_file() for name in (*YAML_FILES, "obj.data"))
    inside = (path / "labels").is_dir() or any(map(any, map(path.glob, ("obj_*_data", "*/labels"))))
    files = label_files(path)
    return bool(files) and (names or inside or any(is_label_file(path / name) for name in files[:9]))


FORMAT = Format(
    name="yolo",
    title="YOLO (Ultralytics)",
    summary="One text file per picture with relative coordinates, ready for training; tracks in a CSV beside.",
    write=_write,
    read=read_yolo,
    sniff=_sniff,
    export_switches=(
        Switch("image", ("jpg", "png"), "Format of the exported pictures."),
        Switch("ignored", ("leave-out", "box"), "Boxes to ignore: left out, or written like all others."),
    ),
    import_switches=(
        *PICTURE_SWITCHES,
        LINK_SWITCH,
        Switch("column6", ("auto", "track", "confidence"), "Meaning of a sixth column; auto: decided over all files."),
    ),
    ignores=False,
    docs="yolo.md",
)
