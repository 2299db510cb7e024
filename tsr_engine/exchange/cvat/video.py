"""CVAT for video 1.1: tracks with key frames in one XML file.

Every shown frame is written, key frames with ``keyframe="1"``; CVAT's importer keeps only those and interpolates
linearly. A gap, and the end of a track, is one more box with ``outside="1"``. Coordinates are px edges from 0 with two
decimals; CVAT for video 1.1 is described in ``format-cvat.md`` of CVAT's documentation.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TextIO

import numpy as np

from tsr_engine.exchange.attributes import at_row, ours_in, said_in
from tsr_engine.exchange.checks import SIZE_SWITCH, ImportValidator
from tsr_engine.exchange.cvat.common import (
    OWN_NAMES,
    SHAPES,
    attribute_line,
    attributes_of,
    box_edges,
    declare_labels,
    find_files,
    flag,
    header,
    label_lines,
    sniff_mode,
    source_of,
    written_attributes,
)
from tsr_engine.exchange.cvat.tasks import TaskOfVideo
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Skipped, Track
from tsr_engine.exchange.formats import ExportOptions, Format, ImportTarget, Switch
from tsr_engine.exchange.labels import ClassMap, class_map
from tsr_engine.exchange.names import video_names
from tsr_engine.exchange.notes import notes_from_text, notes_to_text
from tsr_engine.exchange.output_sink import OutputSink
from tsr_engine.exchange.pictures import WrittenPicture, frames_of, wanted_frames, write_pictures
from tsr_engine.exchange.reading import refuse
from tsr_engine.exchange.rounding import rounded
from tsr_engine.exchange.split import SUBSETS, subset_of
from tsr_engine.exchange.subject import TASK_SWITCH
from tsr_engine.exchange.thinning import key_frames
from tsr_engine.exchange.xml import Node, attribute, elements, quoted
from tsr_engine.io.plain_numbers import real_number
from tsr_engine.json_shapes import JsonObject
from tsr_engine.plural import plural

__all__ = ["FORMAT"]

_DECIMALS = 2
_ROUNDING = 0.5 * 10**-_DECIMALS


def _write(dataset: Dataset, out: OutputSink, options: ExportOptions) -> tuple[list[Skipped], JsonObject]:
    labels = class_map(dataset, options.used_labels)
    extra = [*(["ignore"] if labels.ignore else []), *(["frame_label"] if labels.changes else [])]
    subsets = [name for name in SUBSETS if name in set(options.split.values())] if options.split else ["default"]
    total = sum(1 for video in dataset.videos for _ in video.tracks())
    pictures: list[WrittenPicture] = []
    parts: list[JsonObject] = []
    done = keys = 0
    folders = _folders(dataset, subsets)
    for place, video in enumerate(dataset.videos):
        for subset in subsets:
            name = folders[place, subset]
            with out.text(f"{name}/annotations.xml" if name else "annotations.xml") as file:
                file.writelines(
                    header(
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
            parts.append({"folder": name, "video": place, "subset": subset, "tracks": number})
        prefix = next(folders[place, subset] for subset in subsets)
        pictures += _pictures(video, place, out, prefix if len(subsets) == 1 else _stem(folders, place), options)
    reported = {"origin": 0, "decimals": _DECIMALS, "key_frames": keys, "parts": parts, "pictures": pictures}
    return [], reported


def _folders(dataset: Dataset, subsets: list[str]) -> dict[tuple[int, str], str]:
    """Folder of each video and subset; a CVAT file holds one video, so several videos need a folder each."""
    found: dict[tuple[int, str], str] = {}
    for place, own in enumerate(video_names(dataset.videos)):
        for subset in subsets:
            if len(dataset.videos) == 1:
                found[place, subset] = "" if len(subsets) == 1 else subset
            else:
                found[place, subset] = own if len(subsets) == 1 else f"{own}_{subset}"
    return found


def _stem(folders: dict[tuple[int, str], str], place: int) -> str:
    """Folder of the pictures of a video with several subsets, beside the subsets' folders."""
    names = [name for (at, _), name in folders.items() if at == place]
    return names[0].rsplit("_", 1)[0] if "_" in names[0] else ""


def _pictures(
    video: DatasetVideo, place: int, out: OutputSink, home: str, options: ExportOptions
) -> Iterator[WrittenPicture]:
    if options.pictures == "none":
        return
    frames = wanted_frames(video, frames_of(video), options.pictures)
    base = f"{home}/images" if home else "images"
    names = [f"{base}/frame_{frame:06d}.{options.switches.get('image', 'png')}" for frame in frames.tolist()]
    for count, picture in enumerate(write_pictures(video, place, frames, out, names)):
        options.progress(count + 1, len(frames))
        yield picture


def _write_track(
    out: TextIO, number: int, track: Track, video: DatasetVideo, labels: ClassMap, options: ExportOptions
) -> int:
    """Write one ``<track>``; return the number of its key frames."""
    key = key_frames(track, options.thin_px, rounding=_ROUNDING)
    boxes = rounded(track.boxes, _DECIMALS, video.width, video.height).tolist()
    uid = attribute_line("uid", track.uid)
    fixed = (
        attribute_line("state", track.state)
        + attribute_line("source", track.source)
        + attribute_line("note", notes_to_text(track.notes))
    )
    own = written_attributes(track.attributes)
    every = options.switches.get("rows", "all") == "all"
    frames, occluded, score = track.frames.tolist(), track.occluded.tolist(), track.score.tolist()
    lines = [f' <track id="{number}" label={quoted(labels.name(track.label))} source="{source_of(track)}">\n']
    last = len(frames) - 1
    for k, (frame, is_key) in enumerate(zip(frames, key.tolist(), strict=True)):
        if is_key or every:
            x1, y1, x2, y2 = boxes[k]
            value = score[k]
            changing = uid + own + written_attributes(at_row(track, k))
            changing += f'<attribute name="score">{value:.6g}</attribute>' if value == value else ""
            if track.ignore is not None and track.ignore[k]:
                changing += attribute_line("ignore", "true")
            if track.labels is not None and track.labels[k] != track.label:
                changing += attribute_line("frame_label", labels.name(int(track.labels[k])))
            lines.append(
                f'  <box frame="{frame}" keyframe="{is_key:d}" outside="0" occluded="{occluded[k]:d}" xtl="{x1:.2f}" '
                f'ytl="{y1:.2f}" xbr="{x2:.2f}" ybr="{y2:.2f}" z_order="0">{changing}{fixed if is_key else ""}</box>\n'
            )
        ends = k == last or frames[k + 1] != frame + 1
        if ends and frame + 1 < video.frames:
            x1, y1, x2, y2 = boxes[k]
            lines.append(
                f'  <box frame="{frame + 1}" keyframe="1" outside="1" occluded="0" xtl="{x1:.2f}" ytl="{y1:.2f}" '
                f'xbr="{x2:.2f}" ybr="{y2:.2f}" z_order="0">{uid}{own}</box>\n'
            )
    lines.append(" </track>\n")
    out.writelines(lines)
    return int(np.count_nonzero(key))


def _read(path: Path, target: ImportTarget) -> Dataset:
    validator = ImportValidator(target)
    files = find_files(path, target.video)
    for file, name in files:
        task = TaskOfVideo(Node("meta", {}, 1), validator, name)
        for node in elements(file, "annotations", ("meta", "track", "image"), name=name):
            if node.tag == "meta":
                task = TaskOfVideo(node, validator, name)
                declare_labels(node, validator)
            elif node.tag == "image":
                raise refuse(name, node.line, "has <image> elements: it is CVAT for images. Import it in that format.")
            elif task.has(node, name):
                _read_track(node, name, validator, task)
        if task.others:
            validator.skip(f"{name}: {plural(task.others, 'track')}", "They are of other tasks.")
    return validator.finish(files[0][1], interpolate=True)


def _read_track(node: Node, file: str, validator: ImportValidator, task: TaskOfVideo) -> None:
    shapes = {child.tag for child in node.children} & SHAPES
    if shapes:
        validator.skip(f"{file}, line {node.line}: track", f"It consists of {', '.join(sorted(shapes))}, not of boxes.")
        return
    label = validator.label(attribute(node, "label", file), file, node.line)
    rows = [(child, attributes_of(child)) for child in node.all("box")]
    said = next((values["uid"] for _, values in rows if values.get("uid", "").strip()), "").strip()
    uid = validator.unique(said or f"cvat-{node.attrib.get('id', node.line)}", file, node.line)
    first: Mapping[str, str] = {}
    last_row = -1
    # FiftyOne marks key frames only for labels that know them. Its other boxes are all stated.
    says = any("keyframe" in child.attrib for child, _ in rows)
    for child, values in rows:
        is_key = flag(child, "keyframe", file, str(int(not says)))
        outside = flag(child, "outside", file, "0")
        frame = _frame(child, file, validator, task, outside=outside)
        if not outside:
            last_row = max(last_row, frame)
        if not is_key and "keyframe" in child.attrib:
            continue
        if outside:
            validator.end(uid, frame)
            continue
        ours = ours_in(values)
        first = first or ours
        own = values.get("frame_label", "").strip()
        validator.box(
            uid,
            frame,
            box_edges(child, file, validator, task.scale),
            validator.label(own, file, child.line) if own else label,
            file=file,
            line=child.line,
            key=is_key,
            occluded=flag(child, "occluded", file, "0"),
            ignore=values.get("ignore", "").strip().lower() == "true",
            score=_score(values.get("score", "").strip(), file, child),
            said=said_in(values, OWN_NAMES),
        )
    validator.describe(
        uid,
        state=first.get("state", "").strip() or "open",
        source=first.get("source", "").strip() or "imported",
        notes=notes_from_text(first.get("note", ""), max(last_row, 0)),
        until=last_row,
    )


def _frame(node: Node, file: str, validator: ImportValidator, task: TaskOfVideo, *, outside: bool) -> int:
    value, count = attribute(node, "frame", file), validator.target.video.frames
    # The mark of the end may lie one step of the task after the last frame.
    if outside and value in {str(task.offset + count + more) for more in range(task.step)}:
        return count
    return validator.frame(value, file, node.line, origin=task.offset)


def _score(value: str, file: str, node: Node) -> float:
    if not value:
        return math.nan
    try:
        return real_number(value)
    except ValueError:
        raise refuse(file, node.line, f"the attribute score must be a number. Got {value[:40]!r}.") from None


FORMAT = Format(
    name="cvat-video",
    title="CVAT for video 1.1",
    summary="Tracks with key frames in one XML file, for correction in CVAT.",
    write=_write,
    read=_read,
    sniff=lambda path: sniff_mode(path) == "interpolation",
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
