"""Writes a file a picture."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from tsr_engine.exchange.attributes import value_as_text, written_name
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Skipped
from tsr_engine.exchange.file_listing import head_of, is_system_file
from tsr_engine.exchange.formats import ExportOptions, Format, Switch, Written
from tsr_engine.exchange.frame_rows import RowLists
from tsr_engine.exchange.import_validator import SIZE_SWITCH
from tsr_engine.exchange.labels import UNKNOWN, class_map
from tsr_engine.exchange.linking import LINK_SWITCH
from tsr_engine.exchange.nearby_manifest import is_wrapper
from tsr_engine.exchange.notes import notes_to_text
from tsr_engine.exchange.output_sink import OutputSink
from tsr_engine.exchange.picture_lists import IMAGE_SWITCH, PictureList, make_picture_lists, write_listed_pictures
from tsr_engine.exchange.picture_sequences import PICTURE_SWITCHES
from tsr_engine.exchange.rounding import round_boxes, round_to_pixels
from tsr_engine.exchange.split import names_of_subsets
from tsr_engine.exchange.voc.reader import annotation_folder, read_voc
from tsr_engine.exchange.xml import escape_text
from tsr_engine.labels.model import AttributeValue
from tsr_engine.track_table import NO_CLASS

_DECIMALS = 2
_BOX = "<bndbox><xmin>{0}</xmin><ymin>{0}</ymin><xmax>{0}</xmax><ymax>{0}</ymax></bndbox>"
_KEY = tuple(f"<attribute><name>keyframe</name><value>{word}</value></attribute>" for word in ("false", "true"))


def _write(dataset: Dataset, out: OutputSink, options: ExportOptions) -> Written:
    labels = class_map(dataset, options.used_labels)
    suffix = options.switches.get("image", "jpg")
    names = {label.id: escape_text(label.name) for label in labels.labels} | {NO_CLASS: escape_text(UNKNOWN)}
    devkit = options.switches.get("coordinates", "cvat") == "devkit"
    lists = make_picture_lists(dataset, options, rounding=1.0 if devkit else 0.5 * 10**-_DECIMALS)
    total = sum(len(part.frames) for part in lists)
    done = 0
    for subset in names_of_subsets(options.split):
        stems: list[str] = []
        for part in lists:
            boxes = _corners(part, devkit)
            track_attributes, picture_head = _heads(part), _top(part.video)
            rows = part.rows.as_lists()
            attributes_at = part.rows.attributes_at
            for frame, row_range in part.frames_and_rows(subset):
                stem = part.stem(frame)
                stems.append(stem)
                content = _picture(
                    picture_head, rows, f"{stem}.{suffix}", row_range, boxes, track_attributes, names, attributes_at
                )
                out.put(f"Annotations/{stem}.xml", content.encode())
                done += 1
                options.progress(done, total)
        listed = "".join(f"{stem}\n" for stem in stems)
        out.put(f"ImageSets/Main/{subset}.txt", listed.encode("ascii"))
    skipped = _write_label_map(out, labels.names)
    pictures = write_listed_pictures(
        lists, out, options, lambda part, frame, _: f"JPEGImages/{part.stem(frame)}.{suffix}"
    )
    entries: dict[str, object] = {
        "coordinates": "devkit" if devkit else "cvat",
        "origin": 1 if devkit else 0,
        "corners": "pixels from 1, both inclusive, whole" if devkit else "edges from 0, lower right one exclusive",
        "pictures": pictures,
    }
    return skipped, entries


def _write_label_map(out: OutputSink, labels: list[str]) -> list[Skipped]:
    """CVAT's and Datumaro's list of names; colons separate its fields, so a name with a colon cannot be written."""
    if any(":" in name or "\n" in name or name.startswith("#") for name in labels):
        return [Skipped("labelmap.txt", "A class name has a colon, which separates the fields of that file.")]
    lines = ["# label:color_rgb:parts:actions\n", *(f"{name}:::\n" for name in labels)]
    out.put("labelmap.txt", "".join(lines).encode())
    return []


def _corners(part: PictureList, devkit: bool) -> list[str]:
    """The element of each row's corners."""
    video = part.video
    if devkit:
        pixels = round_to_pixels(part.rows.table.boxes, video.width, video.height)
        pixels[:, :2] += 1
        pattern, rows = _BOX.format("%d"), pixels.tolist()
    else:
        pattern = _BOX.format(f"%.{_DECIMALS}f")
        rows = round_boxes(part.rows.table.boxes, _DECIMALS, video.width, video.height).tolist()
    return [pattern % tuple(row) for row in rows]


def _top(video: DatasetVideo) -> str:
    """The text between the name of a picture and its objects."""
    return (
        "</filename>\n<source><database>Unknown</database><annotation>Unknown</annotation><image>Unknown</image>"
        f"</source>\n<size><width>{video.width}</width><height>{video.height}</height><depth>3</depth></size>"
        "<segmented>0</segmented>\n"
    )


def _heads(part: PictureList) -> list[str]:
    """Attributes that all boxes of a track share."""
    return [
        _attribute("track_id", str(part.first_track + number))
        + _attribute("uid", info.uid)
        + _attribute("state", info.state)
        + _attribute("source", info.source)
        + (_attribute("note", notes_to_text(info.notes)) if info.notes else "")
        + _attributes(info.attributes)
        for number, info in enumerate(part.rows.tracks, start=1)
    ]


def _attributes(values: Mapping[str, AttributeValue]) -> str:
    return "".join(_attribute(written_name(name), value_as_text(value)) for name, value in values.items())


def _attribute(name: str, value: str) -> str:
    return f"<attribute><name>{escape_text(name)}</name><value>{escape_text(value)}</value></attribute>"


def _picture(
    picture_head: str,
    rows: RowLists,
    name: str,
    row_range: slice,
    boxes: list[str],
    track_attributes: list[str],
    names: dict[int, str],
    attributes_at: Callable[[int], Mapping[str, AttributeValue]],
) -> str:
    out = [f"<annotation><folder/><filename>{escape_text(name)}{picture_head}"]
    for k in range(row_range.start, row_range.stop):
        score = rows.score[k]
        attributes = f"<attribute><name>score</name><value>{score:.9g}</value></attribute>" if score == score else ""
        attributes += _attributes(attributes_at(k))
        out.append(
            f"<object><name>{names[rows.class_id[k]]}</name><truncated>0</truncated>"
            f"<occluded>{rows.occluded[k]:d}</occluded><difficult>{rows.ignore[k]:d}</difficult>\n"
            f"{boxes[k]}\n<attributes>{_KEY[rows.key[k]]}{attributes}{track_attributes[rows.track[k]]}</attributes></object>\n"
        )
    out.append("</annotation>\n")
    return "".join(out)


def _sniff(path: Path) -> bool:
    if is_wrapper(path) and not (path / "Annotations").is_dir():
        return False
    if path.is_dir():
        file = next((each for each in annotation_folder(path).rglob("*.xml") if not is_system_file(each.name)), None)
    else:
        file = path if path.suffix.lower() == ".xml" else None
    start = b"" if file is None else head_of(file)
    return b"<annotation>" in start or b"<annotation " in start


FORMAT = Format(
    name="voc",
    title="Pascal VOC",
    summary="One XML file per picture; corners as in CVAT or as in the VOC devkit.",
    write=_write,
    read=read_voc,
    sniff=_sniff,
    export_switches=(
        Switch("coordinates", ("cvat", "devkit"), "Edges from 0 with decimals, or whole pixels from 1."),
        IMAGE_SWITCH,
    ),
    import_switches=(
        Switch("coordinates", ("auto", "cvat", "devkit"), "As for export; auto: by the manifest, else by the numbers."),
        *PICTURE_SWITCHES,
        SIZE_SWITCH,
        LINK_SWITCH,
    ),
    key_frames=True,
    docs="voc.md",
)
