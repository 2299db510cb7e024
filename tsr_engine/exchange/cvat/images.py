"""CVAT for images 1.1: boxes by picture in one XML file.

CVAT has no tracks in pictures, so a track is the boxes that share the attribute ``uid``. ``format-cvat.md`` of CVAT's
documentation describes the format.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.attributes import ignore_marks, label_values, track_facts
from tsr_engine.exchange.cvat.common import (
    SHAPES,
    TOOL_ATTRIBUTES,
    attribute_line,
    attribute_lines,
    attributes_of,
    box_edges,
    declare_labels,
    detect_mode,
    fact_lines,
    find_files,
    header_lines,
    label_lines,
    original_scale,
    read_flag,
    read_ignore,
    read_score,
    source_of,
)
from tsr_engine.exchange.cvat.tasks import tasks_of
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.formats import ExportOptions, Format, ImportTarget, Written
from tsr_engine.exchange.frame_rows import FrameRows
from tsr_engine.exchange.frames_of_pictures import frames_of_pictures
from tsr_engine.exchange.import_validator import SIZE_SWITCH, ImportValidator
from tsr_engine.exchange.labels import ClassMap, class_map
from tsr_engine.exchange.output_sink import OutputSink
from tsr_engine.exchange.picture_lists import IMAGE_SWITCH, make_picture_lists, write_listed_pictures
from tsr_engine.exchange.picture_sequences import PICTURE_SWITCHES, ListedPicture
from tsr_engine.exchange.reading import rule_error
from tsr_engine.exchange.rounding import round_boxes
from tsr_engine.exchange.xml import Node, attribute, elements, number_attribute, quote_attribute

_DECIMALS = 2
_TOOL_ATTRIBUTES = TOOL_ATTRIBUTES | {"track_id"}


def _write(dataset: Dataset, out: OutputSink, options: ExportOptions) -> Written:
    labels = class_map(dataset, options.used_labels)
    suffix = options.switches.get("image", "jpg")
    lists = make_picture_lists(dataset, options)
    total = sum(len(part.frames) for part in lists)
    done = 0
    with out.text("annotations.xml") as file:
        single = dataset.videos[0] if len(dataset.videos) == 1 else None
        file.writelines(
            header_lines(
                name=Path(single.name).stem if single else "drives",
                size=total,
                mode="annotation",
                subset="default",
                labels=label_lines(labels, ["ignore"] if labels.ignore else [], mutable=False),
                video=single,
            )
        )
        for part in lists:
            video, rows = part.video, part.rows
            track_attributes = _heads(rows)
            boxes = round_boxes(rows.table.boxes, _DECIMALS, video.width, video.height).tolist()
            for (frame, row_range), subset_name in zip(part.frames_and_rows(), part.subset, strict=True):
                subset = f' subset="{subset_name}"' if options.split else ""
                file.write(
                    # CVAT's tasks of a video take the id as the frame, whatever the name is.
                    f' <image id="{part.first_frame + frame}" '
                    f"name={quote_attribute(f'{part.stem(frame)}.{suffix}')}{subset} "
                    f'width="{video.width}" height="{video.height}">\n'
                )
                file.writelines(
                    _box(rows, k, boxes[k], track_attributes, labels) for k in range(row_range.start, row_range.stop)
                )
                file.write(" </image>\n")
                done += 1
                options.progress(done, total)
        file.write("</annotations>\n")
    pictures = write_listed_pictures(lists, out, options, lambda part, frame, _: f"images/{part.stem(frame)}.{suffix}")
    return [], {"origin": 0, "decimals": _DECIMALS, "pictures": pictures}


def _heads(rows: FrameRows) -> list[str]:
    """Attributes that all boxes of a track share."""
    return [
        attribute_line("uid", info.uid) + fact_lines(info) + attribute_lines(info.attributes) for info in rows.tracks
    ]


def _box(rows: FrameRows, k: int, edges: list[float], track_attributes: list[str], labels: ClassMap) -> str:
    x1, y1, x2, y2 = edges
    score = float(rows.table.score[k])
    attributes = track_attributes[rows.table.track[k]] + attribute_lines(rows.attributes_at(k))
    attributes += f'<attribute name="score">{score:.6g}</attribute>' if score == score else ""
    attributes += attribute_line("ignore", "true") if rows.table.ignore[k] else ""
    source = source_of(rows.tracks[rows.table.track[k]])
    return (
        f'  <box label={quote_attribute(labels.name(int(rows.table.class_id[k])))} source="{source}" '
        f'occluded="{int(rows.table.occluded[k])}" xtl="{x1:.2f}" ytl="{y1:.2f}" xbr="{x2:.2f}" ybr="{y2:.2f}" '
        f'z_order="0">{attributes}</box>\n'
    )


def _read(path: Path, target: ImportTarget) -> Dataset:
    validator = ImportValidator(target)
    files = find_files(path, target.video)
    listed, sizes = _listed(files, validator)
    frames = iter(frames_of_pictures(listed, validator, path if path.is_dir() else path.parent))
    for file, name in files:
        tags = shapes = 0
        for node in elements(file, "annotations", ("image",), name=name):
            frame = next(frames)
            if frame is None:
                continue
            tags += sum(child.tag == "tag" for child in node.children)
            shapes += sum(child.tag in SHAPES for child in node.children)
            if any(child.tag == "box" for child in node.children):
                _read_image(node, frame, sizes.get((name, node.attrib.get("task_id", ""))), name, validator)
        for count, what, reason in (
            (tags, "tags", "They are about whole pictures."),
            (shapes, "shapes", "They are not boxes."),
        ):
            if count:
                validator.skip(f"{name}: {count} {what}", reason)
    return validator.finish(files[0][1])


def _listed(
    files: list[tuple[Path, str]], validator: ImportValidator
) -> tuple[list[ListedPicture], dict[tuple[str, str], Node]]:
    """The pictures of all files, and each task's ``<original_size>``; a single task is also found without its id."""
    listed: list[ListedPicture] = []
    sizes: dict[tuple[str, str], Node] = {}
    for file, name in files:
        tasks: dict[str, Node] = {}
        pictures: list[Node] = []
        offsets: dict[str, int] = {}
        for node in elements(file, "annotations", ("meta",), without_content=("image", "track"), name=name):
            if node.tag == "track":
                raise rule_error(
                    name, node.line, "has <track> elements: it is CVAT for video. Import it in that format."
                )
            if node.tag == "meta":
                declare_labels(node, validator)
                tasks = _tasks(node)
                with suppress(ImportFormatError):  # not CVAT's own: without sizes nothing was added
                    offsets = {task.id: task.offset for task in tasks_of(node, name)}
                sizes |= {(name, key): size for key, task in tasks.items() if (size := task.child("original_size"))}
                size = node.child("original_size")
                if size is not None:
                    sizes[name, ""] = size
            else:
                pictures.append(node)
        several = len({node.attrib.get("task_id", "") for node in pictures}) > 1
        for node in pictures:
            key = node.attrib.get("task_id", "")
            task = tasks.get(key)
            source, task_name = ("", "") if task is None else (task.value("source"), task.value("name"))
            video_name = source or (f"task {key}" if several else "")
            picture = _name_in_task(node, offsets.get(key, 0), name)
            listed.append(ListedPicture(picture, name, node.line, video=video_name, task_name=task_name))
    return listed, sizes


def _name_in_task(node: Node, offset: int, file: str) -> str:
    """A picture's name; CVAT numbers the frames of a project's videos one after the other, in names too."""
    name, number = attribute(node, "name", file), node.attrib.get("id", "")
    if number.isdecimal() and len(number) < 10 and int(number) >= offset and name == f"frame_{int(number):06d}":
        return f"frame_{int(number) - offset:06d}"
    return name


def _tasks(meta: Node) -> dict[str, Node]:
    """The tasks in a file by id; a single task has the empty id too, because its pictures do not name it."""
    found: dict[str, Node] = {}
    for node in meta.children:
        tasks = node.child("tasks")
        inside = [node] if tasks is None else list(tasks.all("task"))
        if node.tag in ("task", "job", "project"):
            found |= {task.value("id"): task for task in inside}
    if len(found) == 1:
        found[""] = next(iter(found.values()))
    return found


def _scale(node: Node, size: Node | None, file: str, validator: ImportValidator) -> tuple[float, float]:
    # Datumaro leaves the size out if it does not know the picture.
    if "width" in node.attrib or "height" in node.attrib:
        return validator.scale(
            number_attribute(node, "width", file), number_attribute(node, "height", file), file, node.line
        )
    return (1.0, 1.0) if size is None else original_scale(size, validator, file)


def _read_image(node: Node, frame: int, size: Node | None, file: str, validator: ImportValidator) -> None:
    """Take the boxes of one picture."""
    scale = _scale(node, size, file, validator)
    for count, child in enumerate(node.all("box")):
        if read_flag(child, "outside", file, "0"):
            # Datumaro copies CVAT's marks of the end of a track into pictures.
            continue
        values = attributes_of(child)
        stated_uid = (values.get("uid", "") or values.get("track_id", "")).strip()
        uid = stated_uid or f"frame{frame}-{count + 1}"
        if not stated_uid:
            uid = validator.unique_uid(uid, file, child.line)
        label = validator.label(attribute(child, "label", file), file, child.line)
        marks = ignore_marks(values)
        validator.box(
            uid,
            frame,
            box_edges(child, file, validator, scale),
            label,
            file=file,
            line=child.line,
            occluded=read_flag(child, "occluded", file, "0"),
            ignore=read_ignore(values, marks),
            score=read_score(values, file, child),
            attributes=label_values(values, _TOOL_ATTRIBUTES | marks),
            facts=track_facts(values),
        )


FORMAT = Format(
    name="cvat-images",
    title="CVAT for images 1.1",
    summary="Boxes per picture in one XML file; an attribute names the track of each box.",
    write=_write,
    read=_read,
    sniff=lambda path: detect_mode(path) == "annotation",
    export_switches=(IMAGE_SWITCH,),
    import_switches=(*PICTURE_SWITCHES, SIZE_SWITCH),
    docs="cvat-images.md",
)
