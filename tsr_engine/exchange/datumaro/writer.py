"""Writes Datumaro JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator

from tsr_engine.exchange.attributes import json_members, track_attributes, written_name
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.datumaro.reader import read_datumaro, sniff_datumaro
from tsr_engine.exchange.formats import ExportOptions, Format, Switch, Written
from tsr_engine.exchange.import_validator import SIZE_SWITCH
from tsr_engine.exchange.labels import UNKNOWN, ClassMap, class_map
from tsr_engine.exchange.output_sink import OutputSink
from tsr_engine.exchange.picture_lists import IMAGE_SWITCH, PictureList, make_picture_lists, write_listed_pictures
from tsr_engine.exchange.picture_sequences import PICTURE_SWITCHES
from tsr_engine.exchange.rounding import round_to_sizes
from tsr_engine.exchange.split import names_of_subsets

_DECIMALS = 4
_STILL_PICTURE = 2
"""Datumaro's number for still pictures."""


def _write(dataset: Dataset, out: OutputSink, options: ExportOptions) -> Written:
    labels = class_map(dataset, options.used_labels)
    suffix = options.switches.get("image", "jpg")
    lists = make_picture_lists(dataset, options, rounding=0.5 * 10**-_DECIMALS)
    total = sum(len(part.frames) for part in lists)
    done = 0
    for subset in names_of_subsets(options.split):
        with out.text(f"annotations/{subset}.json") as file:
            file.write(_head(labels))
            comma = ""
            for part in lists:
                for item in _items(part, subset, suffix, labels):
                    file.write(comma + item)
                    comma = ",\n"
                    done += 1
                    options.progress(done, total)
            file.write("\n]}\n")
    pictures = write_listed_pictures(
        lists, out, options, lambda part, frame, subset: f"images/{subset}/{part.stem(frame)}.{suffix}"
    )
    return [], {"origin": 0, "decimals": _DECIMALS, "pictures": pictures}


def _head(labels: ClassMap) -> str:
    named = [(each.name, [written_name(one.name) for one in each.attributes]) for each in labels.labels]
    if labels.unknown:
        named.append((UNKNOWN, []))
    head = {
        "dm_format_version": "1.0",
        "media_type": _STILL_PICTURE,
        "infos": {},
        "categories": {
            "label": {
                "label_groups": [],
                "labels": [{"name": name, "parent": "", "attributes": attributes} for name, attributes in named],
                # Datumaro keeps only declared attributes when it converts to other formats.
                "attributes": ["occluded", "uid", "score", "state", "source", "note", "ignore"],
            },
            "mask": {"colormap": []},
        },
    }
    return json.dumps(head)[:-1] + ', "items": [\n'


def _items(part: PictureList, subset: str, suffix: str, labels: ClassMap) -> Iterator[str]:
    """The text of each item of a subset."""
    video, rows = part.video, part.rows
    track_fields = [
        json.dumps({"track_id": part.first_track + index + 1, **track_attributes(info)})[1:-1]
        for index, info in enumerate(rows.tracks)
    ]
    boxes = round_to_sizes(rows.table.boxes, _DECIMALS, video.width, video.height)
    json_bools = ("false", "true")
    for frame, row_range in part.frames_and_rows(subset):
        name = part.stem(frame)
        out: list[str] = []
        for number, k in enumerate(range(row_range.start, row_range.stop)):
            score = float(rows.table.score[k])
            out.append(
                f'{{"id":{number},"type":"bbox","attributes":{{"occluded":{json_bools[int(rows.table.occluded[k])]},'
                f'"keyframe":{json_bools[int(rows.table.key[k])]},"outside":false,'
                + (f'"score":{score:.9g},' if score == score else "")
                + ('"ignore":true,' if rows.table.ignore[k] else "")
                + json_members({written_name(name): value for name, value in rows.attributes_at(k).items()})
                + f"{track_fields[rows.table.track[k]]}}},"
                f'"group":0,"label_id":{labels.index(int(rows.table.class_id[k]))},"z_order":0,'
                f'"bbox":[{",".join(map(repr, boxes[k]))}]}}'
            )
        extra = "" if video.times is None else f',"time":{float(video.times[frame]):.6f}'
        yield (
            f'{{"id":{json.dumps(name)},"annotations":[{",".join(out)}],"attr":{{"frame":{frame}{extra}}},'
            f'"image":{{"path":{json.dumps(f"{name}.{suffix}")},"size":[{video.height},{video.width}]}}}}'
        )


FORMAT = Format(
    name="datumaro",
    title="Datumaro JSON",
    summary="Boxes per picture with tracks as attributes, for Datumaro and every format that it converts to.",
    write=_write,
    read=read_datumaro,
    sniff=sniff_datumaro,
    export_switches=(IMAGE_SWITCH,),
    import_switches=(
        *PICTURE_SWITCHES,
        SIZE_SWITCH,
        Switch("interpolate", ("no", "yes"), "Interpolate linearly between the boxes of a track, for sparse files."),
    ),
    key_frames=True,
    docs="datumaro.md",
)
