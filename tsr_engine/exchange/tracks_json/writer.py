"""Writes tracks as JSON."""

from __future__ import annotations

from collections.abc import Mapping

from tsr_engine.exchange.attributes import frame_values
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Track
from tsr_engine.exchange.formats import ExportOptions, Format, Written
from tsr_engine.exchange.frame_origin import FIRST_FRAME_SWITCH
from tsr_engine.exchange.import_validator import SIZE_SWITCH
from tsr_engine.exchange.labels import UNKNOWN, ClassMap, class_map
from tsr_engine.exchange.linking import LINK_SWITCH
from tsr_engine.exchange.output_sink import OutputSink, compact_json
from tsr_engine.exchange.split import subset_of
from tsr_engine.exchange.tracks_csv.writer import file_names
from tsr_engine.exchange.tracks_json.reader import read_tracks_json, sniff_tracks_json
from tsr_engine.exchange.video_matching import TASK_SWITCH
from tsr_engine.json_shapes import JsonObject
from tsr_engine.track_table import NO_CLASS


def _write(dataset: Dataset, out: OutputSink, options: ExportOptions) -> Written:
    total = sum(1 for video in dataset.videos for _ in video.tracks())
    done = 0
    classes = class_map(dataset, options.used_labels)
    names = {label.id: label.name for label in dataset.labels} | {NO_CLASS: UNKNOWN}
    for video, files in zip(dataset.videos, file_names(dataset, options, ".json"), strict=True):
        for subset, name in files:
            with out.text(name) as file:
                file.write(_head(video, classes))
                comma = "\n"
                for track in video.tracks():
                    if subset_of(video, track.uid, options.split) != subset:
                        continue
                    file.write(comma + _track(track, names))
                    comma = ",\n"
                    done += 1
                    options.progress(done, total)
                negatives = [t for t in video.negatives if subset_of(video, t.uid, options.split) == subset]
                texts = ",\n".join(_track(track, names) for track in negatives)
                file.write(f'],\n"negatives":[\n{texts}]}}\n' if negatives else "]}\n")
    return [], {"origin": 0}


def _head(video: DatasetVideo, labels: ClassMap) -> str:
    head = {
        "format": "tsr-tracks",
        "version": 1,
        "video": {
            "name": video.name,
            "sha256": video.sha256,
            "width": video.width,
            "height": video.height,
            "frames": video.frames,
            "rate": None if video.rate is None else f"{video.rate.numerator}/{video.rate.denominator}",
        },
        "classes": [label.name for label in labels.labels],
    }
    return compact_json(head)[:-1] + ',\n"tracks":['


def _track(track: Track, labels: Mapping[int, str]) -> str:
    boxes: list[JsonObject] = []
    for k, (frame, edges, score) in enumerate(
        zip(track.frames.tolist(), track.boxes.tolist(), track.score.tolist(), strict=True)
    ):
        box: JsonObject = {"frame": frame, "box": edges}
        if score == score:
            box["score"] = score
        if not track.key[k]:
            box["key"] = False
        if track.occluded[k]:
            box["occluded"] = True
        if track.ignore is not None and track.ignore[k]:
            box["ignore"] = True
        if track.labels is not None and track.labels[k] != track.label:
            box["class"] = labels[int(track.labels[k])]
        changing = frame_values(track, k)
        if changing:
            box["attributes"] = changing
        boxes.append(box)
    content = {
        "id": track.uid,
        "class": labels[track.label],
        "state": track.state,
        "source": track.source,
        **({"notes": [list(note) for note in track.notes]} if track.notes else {}),
        **({"attributes": dict(track.attributes)} if track.attributes else {}),
        "boxes": boxes,
    }
    return compact_json(content)


FORMAT = Format(
    name="tracks-json",
    title="Tracks as JSON",
    summary="Tracks or detections in plain JSON: lossless, and easy to write from any tracker.",
    write=_write,
    read=read_tracks_json,
    sniff=sniff_tracks_json,
    import_switches=(FIRST_FRAME_SWITCH, TASK_SWITCH, SIZE_SWITCH, LINK_SWITCH),
    allows_pictures=False,
    docs="tracks-json.md",
)
