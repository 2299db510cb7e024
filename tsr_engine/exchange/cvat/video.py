"""CVAT for video 1.1: tracks with key frames in one XML file.

Every shown frame is written, key frames with ``keyframe="1"``; CVAT's importer keeps only those and interpolates
linearly. A gap, and the end of a track, is one more box with ``outside="1"``. Coordinates are px edges from 0 with two
decimals; CVAT for video 1.1 is described in ``format-cvat.md`` of CVAT's documentation.

CVAT takes the attributes of a whole track from its last key frame (``_import_track`` in its
``dataset_manager/bindings.py``), and gives a key frame that lacks an attribute the value of the key frame before
(``get_interpolated_shapes`` in ``annotation.py``). So end marks have the track's attributes, and a value that ends is
written as ended.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

import numpy as np

from tsr_engine.exchange.attributes import frame_values, ignore_marks, label_values, track_facts
from tsr_engine.exchange.box_rules import Edges, scaled
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
    read_flag,
    read_ignore,
    read_score,
    source_of,
)
from tsr_engine.exchange.cvat.tasks import Task, VideoTask
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Track
from tsr_engine.exchange.formats import ExportOptions, Format, ImportTarget, Switch, Written
from tsr_engine.exchange.import_validator import SIZE_SWITCH, ImportValidator
from tsr_engine.exchange.labels import ClassMap, class_map
from tsr_engine.exchange.notes import notes_from_text
from tsr_engine.exchange.output_sink import OutputSink
from tsr_engine.exchange.pictures import WrittenPicture, frames_with_boxes, wanted_frames, write_pictures
from tsr_engine.exchange.reading import rule_error
from tsr_engine.exchange.rounding import round_boxes
from tsr_engine.exchange.split import names_of_subsets, subset_of
from tsr_engine.exchange.thinning import interpolate, key_frames
from tsr_engine.exchange.video_matching import TASK_SWITCH
from tsr_engine.exchange.video_names import video_names
from tsr_engine.exchange.xml import Node, attribute, elements, quote_attribute
from tsr_engine.io.plain_numbers import parse_real
from tsr_engine.json_shapes import JsonObject
from tsr_engine.plural import plural

_DECIMALS = 2
_ROUNDING = 0.5 * 10**-_DECIMALS
_ENDED = '<attribute name="{}"></attribute>'
"""Attribute of a key frame at which a value of the key frame before ends."""


def _write(dataset: Dataset, out: OutputSink, options: ExportOptions) -> Written:
    labels = class_map(dataset, options.used_labels)
    extra = [*(["ignore"] if labels.ignore else []), *(["frame_label"] if labels.changes else [])]
    subsets = names_of_subsets(options.split)
    total = sum(1 for video in dataset.videos for _ in video.tracks())
    pictures: list[WrittenPicture] = []
    parts: list[JsonObject] = []
    done = keys = 0
    for index, (video, video_name) in enumerate(zip(dataset.videos, video_names(dataset.videos), strict=True)):
        # A CVAT file holds one video, so several videos need a folder each.
        folder = "" if len(dataset.videos) == 1 else video_name
        for subset in subsets:
            name = folder if len(subsets) == 1 else "_".join(filter(None, (folder, subset)))
            with out.text(f"{name}/annotations.xml" if name else "annotations.xml") as file:
                file.writelines(
                    header_lines(
                        name=Path(video.name).stem,
                        size=video.frames,
                        mode="interpolation",
                        subset=subset,
                        labels=label_lines(labels, extra, mutable=True),
                        video=video,
                    )
                )
                number = 0
                for track in video.tracks():
                    if subset_of(video, track.uid, options.split) != subset:
                        continue
                    keys += _write_track(file, number, track, video, labels, options)
                    number, done = number + 1, done + 1
                    options.progress(done, total)
                file.write("</annotations>\n")
            parts.append({"folder": name, "video": index, "subset": subset, "tracks": number})
        pictures += _pictures(video, index, out, folder, options)
    entries = {"origin": 0, "decimals": _DECIMALS, "key_frames": keys, "parts": parts, "pictures": pictures}
    return [], entries


def _pictures(
    video: DatasetVideo, video_index: int, out: OutputSink, parent: str, options: ExportOptions
) -> Iterator[WrittenPicture]:
    if options.pictures == "none":
        return
    frames = wanted_frames(video, frames_with_boxes(video), options.pictures)
    base = f"{parent}/images" if parent else "images"
    names = [f"{base}/frame_{frame:06d}.{options.switches.get('image', 'png')}" for frame in frames.tolist()]
    for count, picture in enumerate(write_pictures(video, video_index, frames, out, names)):
        options.progress(count + 1, len(frames))
        yield picture


def _write_track(
    out: TextIO, number: int, track: Track, video: DatasetVideo, labels: ClassMap, options: ExportOptions
) -> int:
    """Write one ``<track>``; return the number of its key frames."""
    key = key_frames(track, options.thin_px, rounding=_ROUNDING)
    boxes = round_boxes(track.boxes, _DECIMALS, video.width, video.height).tolist()
    track_attributes = attribute_line("uid", track.uid) + attribute_lines(track.attributes)
    facts = fact_lines(track)
    has_scores = bool(np.isfinite(track.score).any())
    write_all = options.switches.get("rows", "all") == "all"
    frames, occluded, score = track.frames.tolist(), track.occluded.tolist(), track.score.tolist()
    lines = [f' <track id="{number}" label={quote_attribute(labels.name(track.label))} source="{source_of(track)}">\n']
    last = len(frames) - 1
    for k, (frame, is_key) in enumerate(zip(frames, key.tolist(), strict=True)):
        if is_key or write_all:
            x1, y1, x2, y2 = boxes[k]
            value = score[k]
            frame_attributes = track_attributes + attribute_lines(frame_values(track, k))
            if value == value:
                frame_attributes += f'<attribute name="score">{value:.6g}</attribute>'
            elif has_scores and is_key:
                frame_attributes += _ENDED.format("score")
            if labels.ignore and track.ignore is not None and (is_key or track.ignore[k]):
                frame_attributes += attribute_line("ignore", "true" if track.ignore[k] else "false")
            if track.labels is not None and track.labels[k] != track.label:
                frame_attributes += attribute_line("frame_label", labels.name(int(track.labels[k])))
            elif labels.changes and track.labels is not None and is_key:
                # Empty, so that another label of the track in CVAT holds here too.
                frame_attributes += _ENDED.format("frame_label")
            lines.append(
                f'  <box frame="{frame}" keyframe="{is_key:d}" outside="0" occluded="{occluded[k]:d}" xtl="{x1:.2f}" '
                f'ytl="{y1:.2f}" xbr="{x2:.2f}" ybr="{y2:.2f}" z_order="0">'
                f"{frame_attributes}{facts if is_key else ''}</box>\n"
            )
        ends = k == last or frames[k + 1] != frame + 1
        if ends and frame + 1 < video.frames:
            x1, y1, x2, y2 = boxes[k]
            lines.append(
                f'  <box frame="{frame + 1}" keyframe="1" outside="1" occluded="0" xtl="{x1:.2f}" ytl="{y1:.2f}" '
                f'xbr="{x2:.2f}" ybr="{y2:.2f}" z_order="0">{track_attributes}{facts}</box>\n'
            )
    lines.append(" </track>\n")
    out.writelines(lines)
    return int(np.count_nonzero(key))


def _read(path: Path, target: ImportTarget) -> Dataset:
    validator = ImportValidator(target)
    files = find_files(path, target.video)
    for file, name in files:
        task = VideoTask(Node("meta", {}, 1), validator, name)
        for node in elements(file, "annotations", ("meta", "track", "image"), name=name):
            if node.tag == "meta":
                task = VideoTask(node, validator, name)
                declare_labels(node, validator)
            elif node.tag == "image":
                raise rule_error(
                    name, node.line, "has <image> elements: it is CVAT for images. Import it in that format."
                )
            elif task.includes(node, name):
                _read_track(node, name, validator, task)
        if task.other_count:
            validator.skip(f"{name}: {plural(task.other_count, 'track')}", "They are of other tasks.")
    return validator.finish(files[0][1], interpolate=True)


def _read_track(node: Node, file: str, validator: ImportValidator, task: VideoTask) -> None:
    shapes = {child.tag for child in node.children} & SHAPES
    if shapes:
        validator.skip(f"{file}, line {node.line}: track", f"It consists of {', '.join(sorted(shapes))}, not of boxes.")
        return
    label = validator.label(attribute(node, "label", file), file, node.line)
    rows = [(child, attributes_of(child)) for child in node.all("box")]
    stated_uid = next((values["uid"] for _, values in rows if values.get("uid", "").strip()), "").strip()
    uid = validator.unique_uid(stated_uid or f"cvat-{node.attrib.get('id', node.line)}", file, node.line)
    first_values: dict[str, str] = {}
    last_frame = -1
    last_key: Edges | None = None
    last_facts: JsonObject = {}
    # FiftyOne marks key frames only for labels that know them. Its other boxes are all stated.
    has_keyframe_flags = any("keyframe" in child.attrib for child, _ in rows)
    # Between key frames CVAT moves the box and its angle evenly, so the upright boxes do not lie on straight lines.
    is_rotated = any(child.attrib.get("rotation") for child, _ in rows)
    for k, (child, values) in enumerate(rows):
        is_key = read_flag(child, "keyframe", file, str(int(not has_keyframe_flags)))
        outside = read_flag(child, "outside", file, "0")
        frame = _frame(child, file, validator, task.task, outside=outside)
        if not outside:
            last_frame = max(last_frame, frame)
        if not is_key and "keyframe" in child.attrib:
            # CVAT moves a box towards the key frame at which it ends, or which lies after the end of a job. That key
            # frame is hidden or not in the file, so the last visible row states the movement.
            goes_on = k + 1 < len(rows) and not read_flag(rows[k + 1][0], "outside", file, "0")
            if outside or (goes_on and not is_rotated):
                continue
        if outside:
            # Nobody has seen the frames between the last one of the task with the sign and its next one.
            is_of_task = frame > last_frame and (frame - last_frame) % task.task.step == 0
            shown = min(frame - (task.task.step if is_of_task else 1), validator.target.video.frames - 1)
            end = None if is_rotated else _edges_of_mark(child, task.scale)
            if last_key is not None and end is not None and end != last_key and shown > last_frame:
                line = np.array([last_frame, frame]), np.array([last_key, end])
                x1, y1, x2, y2 = interpolate(*line, np.array([shown]))[0].tolist()
                validator.box(uid, shown, (x1, y1, x2, y2), key=False, **last_facts)
            validator.hide_from(uid, shown + 1)
            last_key = None
            continue
        first_values = first_values or values
        frame_label, marks = values.get("frame_label", "").strip(), ignore_marks(values)
        edges = box_edges(child, file, validator, task.scale)
        last_facts = {
            "label": validator.label(frame_label, file, child.line) if frame_label else label,
            "file": file,
            "line": child.line,
            "occluded": read_flag(child, "occluded", file, "0"),
            "ignore": read_ignore(values, marks),
            "attributes": label_values(values, TOOL_ATTRIBUTES | marks),
        }
        is_taken = validator.box(uid, frame, edges, key=is_key, score=read_score(values, file, child), **last_facts)
        last_key = edges if is_taken and is_key else None
    last_frame_of_task = validator.target.video.frames - 1 if task.task.stop is None else task.task.stop
    if last_key is not None and has_keyframe_flags and last_frame + task.task.step <= last_frame_of_task:
        what = "Tracks without an end (outside=1) end in their last key frame; CVAT shows them up to the last frame"
        validator.count(what, file, node.line)
    state, source, note = track_facts(first_values)
    notes = notes_from_text(note, max(last_frame, 0))
    validator.describe(uid, state=state, source=source, notes=notes, until=last_frame)


def _edges_of_mark(node: Node, scale: tuple[float, float]) -> Edges | None:
    """The box of an end mark, towards which CVAT moves the last one; None: it has none."""
    try:
        x1, y1, x2, y2 = (parse_real(node.attrib.get(name, "")) for name in ("xtl", "ytl", "xbr", "ybr"))
    except ValueError:
        return None
    is_box = -math.inf < x1 < x2 < math.inf and -math.inf < y1 < y2 < math.inf
    return scaled((x1, y1, x2, y2), scale) if is_box else None


def _frame(node: Node, file: str, validator: ImportValidator, task: Task, *, outside: bool) -> int:
    value, count = attribute(node, "frame", file), validator.target.video.frames
    # The mark of the end may lie one step of the task after the last frame.
    first, is_whole = task.offset + count, value.isascii() and value.isdigit() and len(value) < 20
    if outside and is_whole and int(value) in range(first, first + task.step):
        return int(value) - task.offset
    return validator.frame(value, file, node.line, origin=task.offset)


FORMAT = Format(
    name="cvat-video",
    title="CVAT for video 1.1",
    summary="Tracks with key frames in one XML file, for correction in CVAT.",
    write=_write,
    read=_read,
    sniff=lambda path: detect_mode(path) == "interpolation",
    export_switches=(
        Switch(
            "rows", ("all", "keys"), "Write every shown frame, as CVAT does, or only key frames for a smaller file."
        ),
        Switch("image", ("png", "jpg"), "Format of the exported pictures."),
    ),
    import_switches=(TASK_SWITCH, SIZE_SWITCH),
    key_frames=True,
    docs="cvat-video.md",
)
