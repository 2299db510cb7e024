"""Writes sequences of MOT rows."""

from __future__ import annotations

import csv

import numpy as np

from tsr_engine.exchange.attributes import attributes_as_json
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Skipped
from tsr_engine.exchange.formats import ExportOptions, Format, Switch, Written
from tsr_engine.exchange.frame_rows import FrameRows, rows_by_frame
from tsr_engine.exchange.import_validator import SIZE_SWITCH
from tsr_engine.exchange.labels import ClassMap, class_map
from tsr_engine.exchange.linking import LINK_SWITCH
from tsr_engine.exchange.mot.columns import COLUMNS_SWITCH, SCORES_SWITCH
from tsr_engine.exchange.mot.reader import SIDECAR, SIDECAR_COLUMNS, read_mot, sniff_mot
from tsr_engine.exchange.mot.row_values import LABELS_FILE
from tsr_engine.exchange.notes import notes_to_text
from tsr_engine.exchange.output_sink import OutputSink
from tsr_engine.exchange.picture_lists import IMAGE_SWITCH
from tsr_engine.exchange.pictures import WrittenPicture, wanted_frames, write_pictures
from tsr_engine.exchange.rounding import round_boxes
from tsr_engine.exchange.sidecar import ATTRIBUTES_COLUMN
from tsr_engine.exchange.split import names_of_subsets, subset_of, subsets_of_frames
from tsr_engine.exchange.track_numbers import track_numbers
from tsr_engine.exchange.video_names import safe_stem, video_names
from tsr_engine.json_shapes import JsonObject

_DECIMALS = 2


def _write(dataset: Dataset, out: OutputSink, options: ExportOptions) -> Written:
    labels = class_map(dataset, options.used_labels)
    origin = int(options.switches.get("origin", "0"))
    total = sum(1 for video in dataset.videos for _ in video.tracks())
    pictures: list[WrittenPicture] = []
    skipped: list[Skipped] = []
    sequences: list[JsonObject] = []
    done = 0
    # A single video needs no folder.
    folders = [""] if len(dataset.videos) == 1 else video_names(dataset.videos)
    for index, (video, folder) in enumerate(zip(dataset.videos, folders, strict=True)):
        if video.rate is None:
            skipped.append(Skipped(f"{video.name}: frame rate", "It is not known; seqinfo.ini needs one and says 25."))
        for subset in names_of_subsets(options.split):
            name = "/".join(filter(None, (subset if options.split else "", folder)))
            only = {t.uid for t in video.tracks() if subset_of(video, t.uid, options.split) == subset}
            rows = rows_by_frame(video, only=only)
            _write_sequence(
                out, f"{name}/" if name else "", video, rows, labels, origin, name or safe_stem(video.name), options
            )
            pictures += _pictures(video, index, rows, subset, name, out, options)
            sequences.append({"folder": name, "video": index, "tracks": len(rows.tracks)})
            done += len(rows.tracks)
            options.progress(done, total)
    entries = {
        "origin": origin,
        "first_frame": 1,
        "first_class": 1,
        "decimals": _DECIMALS,
        "sequences": sequences,
        "pictures": pictures,
    }
    return skipped, entries


def _write_sequence(
    out: OutputSink,
    prefix: str,
    video: DatasetVideo,
    rows: FrameRows,
    labels: ClassMap,
    origin: int,
    name: str,
    options: ExportOptions,
) -> None:
    ids = track_numbers(info.uid for info in rows.tracks)
    track = [ids[info.uid] for info in rows.tracks]
    boxes = rows.table
    edges = round_boxes(boxes.boxes, _DECIMALS, video.width, video.height)
    edges[:, 2:] -= edges[:, :2]
    edges[:, :2] += origin
    with (
        out.text(f"{prefix}gt/gt.txt", encoding="ascii") as ground_truth,
        out.text(f"{prefix}gt/{SIDECAR}", errors="replace") as sidecar,
    ):
        scored = np.isfinite(boxes.score)
        detections: list[str] = []
        for k, (frame, number, (x, y, w, h)) in enumerate(
            zip(boxes.frame.tolist(), boxes.track.tolist(), edges.tolist(), strict=True)
        ):
            box = f"{x:.2f},{y:.2f},{w:.2f},{h:.2f}"
            label = labels.index(int(boxes.class_id[k])) + 1
            ground_truth.write(
                f"{frame + 1},{track[number]},{box},{int(not boxes.ignore[k])},{label},{int(not boxes.occluded[k])}\n"
            )
            if scored[k]:
                detections.append(f"{frame + 1},-1,{box},{boxes.score[k]:.6g},-1,-1,-1\n")
        table = csv.writer(sidecar, lineterminator="\n")
        table.writerow([*SIDECAR_COLUMNS, ATTRIBUTES_COLUMN])
        for number, info in enumerate(rows.tracks):
            attributes = attributes_as_json(info.attributes)
            table.writerow([track[number], info.uid, info.state, info.source, notes_to_text(info.notes), attributes])
    out.put(f"{prefix}gt/{LABELS_FILE}", "".join(f"{on_one_line(label)}\n" for label in labels.names).encode())
    if detections:
        out.put(f"{prefix}det/det.txt", "".join(detections).encode("ascii"))
    rate = round(video.rate) if video.rate is not None else 25
    sequence_info = {
        "name": on_one_line(name),
        "imDir": "img1",
        "frameRate": max(rate, 1),
        "seqLength": video.frames,
        "imWidth": video.width,
        "imHeight": video.height,
        "imExt": f".{options.switches.get('image', 'jpg')}",
    }
    lines = ["[Sequence]\n", *(f"{key}={value}\n" for key, value in sequence_info.items())]
    out.put(f"{prefix}seqinfo.ini", "".join(lines).encode())


def on_one_line(name: str) -> str:
    """The name on one line, for files with one name a line."""
    return " ".join(name.encode("utf-8", "replace").decode().split()) or "-"


def _pictures(
    video: DatasetVideo,
    video_index: int,
    rows: FrameRows,
    subset: str,
    name: str,
    out: OutputSink,
    options: ExportOptions,
) -> list[WrittenPicture]:
    if options.pictures == "none":
        return []
    frames = wanted_frames(video, rows.frames, options.pictures)
    if options.split and len(frames):
        names, subset_of_frame = subsets_of_frames(video, options.split)
        frames = frames[subset_of_frame[frames] == names.index(subset)]
    base = f"{name}/img1" if name else "img1"
    suffix = options.switches.get("image", "jpg")
    files = [f"{base}/{frame + 1:06d}.{suffix}" for frame in frames.tolist()]
    return list(write_pictures(video, video_index, frames, out, files))


FORMAT = Format(
    name="mot",
    title="MOT 1.1",
    summary="Rows of boxes with track ids for CVAT and tracker benchmarks (MOTChallenge, TrackEval).",
    write=_write,
    read=read_mot,
    sniff=sniff_mot,
    export_switches=(
        Switch("origin", ("0", "1"), "Positions from 0 as in CVAT, or from 1 as in MOTChallenge."),
        IMAGE_SWITCH,
    ),
    import_switches=(
        Switch("origin", ("auto", "0", "1"), "As for export; auto: as the manifest beside the rows says, else 0."),
        Switch("first_frame", ("auto", "0", "1"), "Number of the first frame; auto: 1, as MOT says."),
        Switch(
            "first_class",
            ("auto", "1", "0"),
            "Number of the first class, the first line of labels.txt; auto: 1, but 0 in BoxMOT's rows.",
        ),
        COLUMNS_SWITCH,
        SCORES_SWITCH,
        SIZE_SWITCH,
        LINK_SWITCH,
    ),
    attributes="tracks",
    docs="mot.md",
)
