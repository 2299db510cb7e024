"""Writes tasks for Label Studio."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tsr_engine.errors import ExportError
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Skipped, Track
from tsr_engine.exchange.filters import without_ignored
from tsr_engine.exchange.formats import ExportOptions, Format, Switch, Written
from tsr_engine.exchange.label_studio.controls import CONFIG_FILE, controls, results
from tsr_engine.exchange.label_studio.reader import read_label_studio, sniff_label_studio
from tsr_engine.exchange.labels import ClassMap, class_map
from tsr_engine.exchange.notes import notes_to_text
from tsr_engine.exchange.output_sink import OutputSink, compact_json
from tsr_engine.exchange.split import names_of_subsets, subset_of
from tsr_engine.exchange.thinning import key_frames, run_bounds
from tsr_engine.exchange.video_matching import TASK_SWITCH
from tsr_engine.exchange.video_names import safe_stem, video_names
from tsr_engine.exchange.xml import quote_attribute
from tsr_engine.json_shapes import JsonObject
from tsr_engine.plural import plural
from tsr_engine.version import __version__

_DECIMALS = 6


def _write(dataset: Dataset, out: OutputSink, options: ExportOptions) -> Written:
    for video in dataset.videos:
        _constant_rate(video)
    dataset, ignored = without_ignored(dataset)
    labels = class_map(dataset, options.used_labels)
    total = sum(1 for video in dataset.videos for _ in video.tracks())
    done = keys = lost_scores = occluded = 0
    for subset in names_of_subsets(options.split):
        with out.text(f"tasks_{subset}.json" if options.split else "tasks.json") as file:
            file.write("[")
            for index, (video, export_name) in enumerate(zip(dataset.videos, video_names(dataset.videos), strict=True)):
                rate = _constant_rate(video)
                file.write(("," if index else "") + "\n" + _task_head(video, export_name, rate, subset, options))
                comma = ""
                for track in video.tracks():
                    if subset_of(video, track.uid, options.split) != subset:
                        continue
                    region, count = _region(track, video, rate, labels, options)
                    texts = [region, *map(compact_json, results(track, labels))]
                    file.write(comma + ",".join(f"\n{text}" for text in texts))
                    comma = ","
                    keys += count
                    lost_scores += int(np.isfinite(track.score).sum())
                    occluded += int(track.occluded.sum())
                    done += 1
                    options.progress(done, total)
                file.write("]}]}")
            file.write("\n]\n")
    tags = "".join(f"<Label value={quote_attribute(name)}/>" for name in labels.names)
    config = (
        f'<View><Labels name="videoLabels" toName="video">{tags}</Labels>'
        f'<Video name="video" value="$video" framerate="$fps"/><VideoRectangle name="box" toName="video"/>'
        f"{controls(labels)}</View>\n"
    )
    out.put(CONFIG_FILE, config.encode())
    skipped = [
        Skipped(plural(lost_scores, "score"), "Label Studio has one score per region, which is the mean of the track.")
        if lost_scores
        else None,
        Skipped(plural(occluded, "mark") + " of occlusion", "Label Studio has no such mark.") if occluded else None,
        Skipped(plural(ignored, "box", "boxes") + " to ignore", "Label Studio has no such mark.") if ignored else None,
        Skipped("Labels of single frames", "A region of Label Studio has one label.") if labels.changes else None,
    ]
    entries = {"origin": 1, "unit": "percent of the picture", "decimals": _DECIMALS, "key_frames": keys}
    return [item for item in skipped if item is not None], entries


def _constant_rate(video: DatasetVideo) -> float:
    """Frames a second.

    Raises:
        ExportError: the video has a variable frame rate.
    """
    if not video.constant_rate or video.rate is None or video.rate <= 0:
        raise ExportError(
            f"{video.name} has a variable frame rate. Label Studio finds frames by time and would show other frames. "
            "Convert it to a constant rate and import it again, or choose CVAT for video."
        )
    return float(video.rate)


def _task_head(video: DatasetVideo, export_name: str, rate: float, subset: str, options: ExportOptions) -> str:
    # Label Studio finds a video by its name alone, so two videos of one name must be told apart.
    file_name = video.name if export_name == safe_stem(video.name) else export_name + Path(video.name).suffix
    data: JsonObject = {"video": file_name, "fps": rate, "sha256": video.sha256}
    if options.split:
        data["subset"] = subset
    kind = options.switches.get("as", "predictions")
    head = {"model_version": f"tsr-{__version__}"} if kind == "predictions" else {"was_cancelled": False}
    return f'{{"data":{compact_json(data)},"{kind}":[{compact_json(head)[:-1]},"result":['


def _region(
    track: Track, video: DatasetVideo, rate: float, labels: ClassMap, options: ExportOptions
) -> tuple[str, int]:
    """The text of a region and the number of its key frames."""
    # A millionth of a percent is at most a hundred-thousandth of a pixel.
    key = key_frames(track, options.thin_px, rounding=1e-4)
    bounds = run_bounds(track.frames)
    is_run_end = np.zeros(len(track.frames), dtype=np.bool_)
    is_run_end[bounds[1:] - 1] = True
    frames = track.frames[key] + 1
    size = np.array([video.width, video.height, video.width, video.height], dtype=np.float64)
    edges = track.boxes[key] / size * 100.0
    edges[:, 2:] -= edges[:, :2]
    sequence = [
        {
            "frame": frame,
            "time": time,
            "x": x,
            "y": y,
            "width": width,
            "height": height,
            "rotation": 0,
            "enabled": not is_end,
        }
        for frame, time, (x, y, width, height), is_end in zip(
            frames.tolist(),
            np.round(frames / rate, 6).tolist(),
            np.round(edges, _DECIMALS).tolist(),
            is_run_end[key].tolist(),
            strict=True,
        )
    ]
    meta = [f"uid={track.uid}", f"state={track.state}", f"source={track.source}"]
    meta += [f"note={line}" for line in notes_to_text(track.notes).split("\n") if line]
    region: JsonObject = {
        "id": track.uid,
        "type": "videorectangle",
        "from_name": "box",
        "to_name": "video",
        "origin": "prediction" if options.switches.get("as", "predictions") == "predictions" else "manual",
        "value": {
            "framesCount": video.frames,
            "duration": round(video.frames / rate, 6),
            "labels": [labels.name(track.label)],
            "sequence": sequence,
        },
        "meta": {"text": meta},
    }
    scored = track.score[np.isfinite(track.score)]
    if len(scored):
        region["score"] = round(float(scored.mean()), 6)
    return compact_json(region), len(sequence)


FORMAT = Format(
    name="label-studio",
    title="Label Studio video JSON",
    summary="Tracks with key frames as Label Studio's video rectangles; only for videos of constant frame rate.",
    write=_write,
    read=read_label_studio,
    sniff=sniff_label_studio,
    export_switches=(
        Switch("as", ("predictions", "annotations"), "Predictions to accept one by one, or finished annotations."),
    ),
    import_switches=(TASK_SWITCH,),
    allows_pictures=False,
    key_frames=True,
    attributes="tracks",
    ignores=False,
    docs="label-studio.md",
)
