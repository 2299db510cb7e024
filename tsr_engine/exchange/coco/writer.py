"""Writes COCO."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from tsr_engine.exchange.attributes import json_members, track_attributes, written_name
from tsr_engine.exchange.coco.reader import read_coco
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.file_listing import head_of, list_json_files
from tsr_engine.exchange.formats import ExportOptions, Format, Switch, Written
from tsr_engine.exchange.import_validator import SIZE_SWITCH
from tsr_engine.exchange.labels import ClassMap, class_map
from tsr_engine.exchange.linking import LINK_SWITCH
from tsr_engine.exchange.output_sink import OutputSink, compact_json
from tsr_engine.exchange.picture_lists import IMAGE_SWITCH, PictureList, make_picture_lists, write_listed_pictures
from tsr_engine.exchange.picture_sequences import PICTURE_SWITCHES
from tsr_engine.exchange.rounding import round_to_sizes
from tsr_engine.exchange.split import names_of_subsets

_DECIMALS = 4
_JSON_BOOLS = ("false", "true")


def _write(dataset: Dataset, out: OutputSink, options: ExportOptions) -> Written:
    labels = class_map(dataset, options.used_labels)
    suffix = options.switches.get("image", "jpg")
    lists = make_picture_lists(dataset, options, rounding=0.5 * 10**-_DECIMALS)
    total = sum(len(part.frames) for part in lists)
    done = boxes = 0
    for subset in names_of_subsets(options.split):
        with out.text(f"annotations/instances_{subset}.json") as file:
            file.write('{"info":{},"licenses":[{"id":0,"name":"","url":""}],\n"categories":[')
            categories = [
                {"id": number, "name": name, "supercategory": ""} for number, name in enumerate(labels.names, start=1)
            ]
            file.write(",\n".join(map(compact_json, categories)) + '],\n"images":[')
            comma = "\n"
            for part in lists:
                video_fields = f'{compact_json(part.video.name)},"video_sha256":{compact_json(part.video.sha256)}'
                for frame, _ in part.frames_and_rows(subset):
                    file.write(comma + _image(part, frame, suffix, video_fields))
                    comma = ",\n"
                    done += 1
                    options.progress(done, total)
            file.write('],\n"annotations":[')
            comma = "\n"
            for part in lists:
                for text in _annotations(part, subset, labels, boxes):
                    file.write(comma + text)
                    comma = ",\n"
                    boxes += 1
            file.write("]}\n")
    pictures = write_listed_pictures(
        lists, out, options, lambda part, frame, subset: f"images/{subset}/{part.stem(frame)}.{suffix}"
    )
    return [], {"origin": 0, "first_category": 1, "decimals": _DECIMALS, "pictures": pictures}


def _image(part: PictureList, frame: int, suffix: str, video_fields: str) -> str:
    """One image; its id follows from video and frame, so a detector's results can be matched without this file.

    ``video_fields`` is the text of the video's name and of the keys after it.
    """
    video = part.video
    time = "" if video.times is None else f'"pts":{round(float(video.times[frame]), 6)},'
    # There is one per picture, and encoding a dictionary takes several times as long as this text.
    return (
        f'{{"id":{part.first_frame + frame + 1},"width":{video.width},"height":{video.height},'
        f'"file_name":{json.dumps(f"{part.stem(frame)}.{suffix}")},"license":0,"flickr_url":"","coco_url":"",'
        f'"date_captured":0,"frame":{frame},{time}"video":{video_fields}}}'
    )


def _annotations(part: PictureList, subset: str, labels: ClassMap, count: int) -> Iterator[str]:
    """The text of each annotation; ``count`` is the number of annotations in earlier files."""
    rows = part.rows.as_lists()
    numbers = {label: labels.index(label) + 1 for label in set(rows.class_id)}
    track_fields = [compact_json(track_attributes(info))[1:] for info in part.rows.tracks]
    boxes = round_to_sizes(part.rows.table.boxes, _DECIMALS, part.video.width, part.video.height)
    for frame, row_range in part.frames_and_rows(subset):
        for k in range(row_range.start, row_range.stop):
            count += 1
            score = rows.score[k]
            yield (
                f'{{"id":{count},"image_id":{part.first_frame + frame + 1},'
                f'"category_id":{numbers[rows.class_id[k]]},'
                f'"bbox":[{",".join(map(repr, boxes[k]))}],'
                f'"area":{round(boxes[k][2] * boxes[k][3], 4)},"segmentation":[],"iscrowd":{rows.ignore[k]:d},'
                f'"attributes":{{"occluded":{_JSON_BOOLS[rows.occluded[k]]},"rotation":0.0,'
                f'"track_id":{part.first_track + rows.track[k] + 1},"keyframe":{_JSON_BOOLS[rows.key[k]]},'
                + (f'"score":{score:.9g},' if score == score else "")
                + json_members({written_name(name): value for name, value in part.rows.attributes_at(k).items()})
                + track_fields[rows.track[k]]
                + "}"
            )


def _sniff(path: Path) -> bool:
    for file in list_json_files(path)[:1] if path.is_dir() or path.suffix.lower() == ".json" else []:
        start = head_of(file, 1 << 16)
        if b'"dm_format_version"' in start or b'"media_type"' in start or b'"image/' in start:
            return False
        return (b'"images"' in start and (b'"file_name"' in start or b'"categories"' in start)) or (
            b'"image_id"' in start and b'"bbox"' in start
        )
    return False


FORMAT = Format(
    name="coco",
    title="COCO",
    summary="Boxes per picture in one JSON file, for most detectors; tracks as attributes that CVAT reads.",
    write=_write,
    read=read_coco,
    sniff=_sniff,
    export_switches=(IMAGE_SWITCH,),
    import_switches=(
        *PICTURE_SWITCHES,
        SIZE_SWITCH,
        Switch("interpolate", ("no", "yes"), "Interpolate linearly between the boxes of a track, for sparse files."),
        LINK_SWITCH,
        Switch("first_id", ("1", "0"), "First id in a list of results that comes without its images."),
    ),
    key_frames=True,
    docs="coco.md",
)
