"""Label Studio video JSON: one region a track, key frames in percent of the picture.

Frames count from 1 and a frame's time is its number divided by the frame rate, so only videos of constant rate fit.
``enabled: false`` says that a region is not shown after that key frame, until its next one. Described in
``videorectangle.md`` of Label Studio's documentation.
"""

from __future__ import annotations

import json
import math
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tsr_engine.errors import ExportError
from tsr_engine.exchange.checks import Intake, read_json, refuse
from tsr_engine.exchange.dataset import UNSAID, Dataset, DatasetVideo, Skipped, Track
from tsr_engine.exchange.formats import ExportOptions, Format, ImportTarget, Switch
from tsr_engine.exchange.labels import label_name, used_labels
from tsr_engine.exchange.names import is_name_of, safe_stem, video_names
from tsr_engine.exchange.notes import notes_from_text, notes_to_text
from tsr_engine.exchange.outlet import Outlet
from tsr_engine.exchange.split import SUBSETS, subset_of
from tsr_engine.exchange.thinning import key_frames, runs_of
from tsr_engine.exchange.xml import quoted
from tsr_engine.version import __version__

__all__ = ["FORMAT"]

_DECIMALS = 6
_FILES = ("tasks.json", *(f"tasks_{name}.json" for name in SUBSETS))


def _write(dataset: Dataset, out: Outlet, options: ExportOptions) -> tuple[list[Skipped], dict[str, Any]]:
    if options.pictures != "none":
        raise ExportError("Label Studio shows the video itself. Export without pictures.")
    for video in dataset.videos:
        _constant_rate(video)
    labels, ignore, changes = used_labels(dataset)
    subsets: list[str | None] = [None]
    if options.split:
        subsets = [name for name in SUBSETS if name in set(options.split.values())]
    total = sum(1 for video in dataset.videos for _ in video.tracks())
    done = keys = lost_scores = occluded = 0
    for subset in subsets:
        name = "tasks.json" if subset is None else f"tasks_{subset}.json"
        with out.text(name) as file:
            file.write("[")
            for place, (video, called) in enumerate(zip(dataset.videos, video_names(dataset.videos), strict=True)):
                rate = _constant_rate(video)
                file.write(("," if place else "") + "\n" + _task_head(video, called, rate, subset, options))
                comma = ""
                for track in video.tracks():
                    if subset is not None and subset_of(video, track.uid, options.split) != subset:
                        continue
                    region, count = _region(track, video, rate, dataset.labels, options)
                    file.write(f"{comma}\n{region}")
                    comma = ","
                    keys += count
                    lost_scores += int(np.isfinite(track.score).sum())
                    occluded += int(track.occluded.sum())
                    done += 1
                    options.progress(done, total)
                file.write("]}]}")
            file.write("\n]\n")
    tags = "".join(f"<Label value={quoted(name)}/>" for name in labels)
    config = (
        f'<View><Labels name="videoLabels" toName="video">{tags}</Labels>'
        '<Video name="video" value="$video" framerate="$fps"/><VideoRectangle name="box" toName="video"/></View>\n'
    )
    out.put("label_config.xml", config.encode())
    skipped = [
        Skipped(f"{lost_scores} scores", "Label Studio has one score a region; it is the mean of the track.")
        if lost_scores
        else None,
        Skipped(f"{occluded} marks of occlusion", "Label Studio has none.") if occluded else None,
        Skipped("Marks of regions to ignore", "Label Studio has none.") if ignore else None,
        Skipped("Classes of single frames", "A region of Label Studio has one class.") if changes else None,
    ]
    told = {"origin": 1, "unit": "percent of the picture", "decimals": _DECIMALS, "key_frames": keys}
    return [item for item in skipped if item is not None], told


def _constant_rate(video: DatasetVideo) -> float:
    """Frames a second.

    Raises:
        ExportError: the video has none that holds.
    """
    if not video.constant_rate or video.rate is None or video.rate <= 0:
        raise ExportError(
            f"{video.name} has a variable frame rate; Label Studio finds frames by time and would show others. "
            "Convert it to a constant rate and import it again, or choose CVAT for video."
        )
    return float(video.rate)


def _task_head(video: DatasetVideo, called: str, rate: float, subset: str | None, options: ExportOptions) -> str:
    # Label Studio finds a video by this name alone, so two of one name must be told apart.
    file = video.name if called == safe_stem(video.name) else called + Path(video.name).suffix
    data: dict[str, Any] = {"video": file, "fps": rate, "sha256": video.sha256}
    if subset is not None:
        data["subset"] = subset
    kind = options.switches.get("as", "predictions")
    head = {"model_version": f"tsr-{__version__}"} if kind == "predictions" else {"was_cancelled": False}
    return f'{{"data":{_dump(data)},"{kind}":[{_dump(head)[:-1]},"result":['


def _region(
    track: Track, video: DatasetVideo, rate: float, labels: tuple[str, ...], options: ExportOptions
) -> tuple[str, int]:
    """The text of a region and the number of its key frames."""
    # A millionth of a percent is a hundred-thousandth of a pixel at most.
    key = key_frames(track, options.thin_px, rounding=1e-4)
    bounds = runs_of(track.frames)
    last = np.zeros(len(track.frames), dtype=np.bool_)
    last[bounds[1:] - 1] = True
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
            "enabled": not ends,
        }
        for frame, time, (x, y, width, height), ends in zip(
            frames.tolist(),
            np.round(frames / rate, 6).tolist(),
            np.round(edges, _DECIMALS).tolist(),
            last[key].tolist(),
            strict=True,
        )
    ]
    meta = [f"uid={track.uid}", f"state={track.state}", f"source={track.source}"]
    meta += [f"note={line}" for line in notes_to_text(track.notes).split("\n") if line]
    region: dict[str, Any] = {
        "id": track.uid,
        "type": "videorectangle",
        "from_name": "box",
        "to_name": "video",
        "origin": "prediction" if options.switches.get("as", "predictions") == "predictions" else "manual",
        "value": {
            "framesCount": video.frames,
            "duration": round(video.frames / rate, 6),
            "labels": [label_name(labels, track.label)],
            "sequence": sequence,
        },
        "meta": {"text": meta},
    }
    scored = track.score[np.isfinite(track.score)]
    if len(scored):
        region["score"] = round(float(scored.mean()), 6)
    return _dump(region), len(sequence)


def _dump(value: Any) -> str:
    return json.dumps(value, allow_nan=False, separators=(",", ":"))


def _read(path: Path, target: ImportTarget) -> Dataset:
    video = target.video
    if not video.constant_rate or video.rate is None:
        raise refuse(
            path.name,
            None,
            f"counts frames by time, but {video.name} has a variable frame rate, so its frames are others. Use CVAT.",
        )
    intake = Intake(target)
    files = _files(path)
    if not files:
        raise refuse(path.name, None, "has no JSON file. Export as JSON from Label Studio again.")
    for file in files:
        tasks = read_json(file)
        tasks = [tasks] if isinstance(tasks, dict) else tasks
        if not isinstance(tasks, list) or not all(isinstance(task, dict) for task in tasks):
            raise refuse(file.name, None, "must be a list of tasks. Export as JSON (not JSON-MIN) again.")
        for place, task in _about(tasks, target, file.name, intake):
            _read_task(task, intake, file.name, f"task {place + 1}")
    return intake.finish(files[0].name, interpolate=True)


def _files(path: Path) -> list[Path]:
    if path.is_file():
        return [path]
    ours = [path / name for name in _FILES if (path / name).is_file()]
    return ours or sorted(file for file in path.glob("*.json") if file.name != "manifest.json")


def _about(
    tasks: list[dict[str, Any]], target: ImportTarget, file: str, intake: Intake
) -> list[tuple[int, dict[str, Any]]]:
    """The tasks about the video; a single task is taken to be."""
    numbered = list(enumerate(tasks))
    if len(tasks) <= 1:
        return numbered
    chosen = [(place, task) for place, task in numbered if _is_about(task, target.video)]
    if not chosen:
        raise refuse(
            file, None, f"has {len(tasks)} tasks, none about {target.video.name}. Export the task of this video."
        )
    if len(chosen) < len(tasks):
        intake.skip(f"{file}: {len(tasks) - len(chosen)} tasks", f"They are not about {target.video.name}.")
    return chosen


def _is_about(task: dict[str, Any], video: DatasetVideo) -> bool:
    """By the hash where the task has one, else by the file name; Label Studio puts ``1a2b3c4d-`` before an upload's."""
    data = task.get("data")
    if not isinstance(data, dict):
        return False
    digest = data.get("sha256")
    if digest and video.sha256:
        return bool(digest == video.sha256)
    wanted = Path(video.name).stem.casefold()
    names = [Path(str(value)).stem.casefold() for value in data.values()]
    return any(name == wanted or name.endswith(f"-{wanted}") or is_name_of(name, video) for name in names)


def _read_task(task: dict[str, Any], intake: Intake, file: str, where: str) -> None:
    answers = [
        answer
        for kind in ("annotations", "predictions")
        for answer in _list(task.get(kind))
        if isinstance(answer, dict) and not answer.get("was_cancelled") and isinstance(answer.get("result"), list)
    ]
    if not answers:
        raise refuse(file, where, "has neither annotations nor predictions with a result. Export as JSON again.")
    if len(answers) > 1:
        intake.skip(f"{file}, {where}: {len(answers) - 1} annotations", "Only the first of a task is taken.")
    other = 0
    for place, region in enumerate(answers[0]["result"]):
        spot = f"{where}, region {place + 1}"
        if not isinstance(region, dict):
            raise refuse(file, spot, "must be an object. Correct it.")
        if region.get("type") != "videorectangle":
            other += 1
            continue
        _read_region(region, intake, file, spot)
    if other:
        intake.skip(f"{file}, {where}: {other} results", "They are no video rectangles.")


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []


def _read_region(region: dict[str, Any], intake: Intake, file: str, where: str) -> None:
    value = region.get("value")
    if not isinstance(value, dict) or not isinstance(value.get("sequence"), list):
        raise refuse(file, where, "must have a value with a sequence. Export as JSON again.")
    _check_count(value.get("framesCount"), intake, file, where)
    names = value.get("labels")
    label = intake.label(str(names[0]), file, where) if isinstance(names, list) and names else UNSAID
    meta = _meta(region)
    uid = intake.unique((meta.get("uid") or [str(region.get("id", ""))])[0].strip() or where, file, where)
    video = intake.target.video
    enabled_at: dict[int, bool] = {}
    for place, key in enumerate(value["sequence"]):
        spot = f"{where}, key frame {place + 1}"
        if not isinstance(key, dict):
            raise refuse(file, spot, "must be an object. Correct it.")
        frame = intake.frame(key.get("frame", ""), file, spot, origin=1)
        edges = intake.edges(partial(_edges, key, intake, file, spot))
        if intake.box(uid, frame, edges, label, file=file, line=spot):
            enabled_at[frame] = key.get("enabled", True) is not False
    for frame, enabled in enabled_at.items():
        if not enabled and frame + 1 not in enabled_at:
            intake.end(uid, frame + 1)
    intake.describe(
        uid,
        state=(meta.get("state") or ["open"])[0],
        source=(meta.get("source") or ["imported"])[0],
        notes=notes_from_text("\n".join(meta.get("note", [])), min(enabled_at, default=0)),
        # Enabled at its last key frame, a region stays to the end of the video.
        until=video.frames - 1 if enabled_at and enabled_at[max(enabled_at)] else -1,
    )


def _edges(key: dict[str, Any], intake: Intake, file: str, where: str) -> tuple[float, float, float, float]:
    video = intake.target.video
    x, y, width, height = (
        _number(key, name, file, where) / 100 * side
        for name, side in (("x", video.width), ("y", video.height), ("width", video.width), ("height", video.height))
    )
    turn = _number(key, "rotation", file, where) if key.get("rotation") else 0.0
    if turn % 360 and math.isfinite(turn):
        x, y, width, height = _upright(x, y, width, height, turn)
        intake.count("Turned boxes were replaced by the upright boxes around them", file, where)
    return x, y, x + width, y + height


def _check_count(count: Any, intake: Intake, file: str, where: str) -> None:
    video = intake.target.video
    # Label Studio rounds the duration, so it may be off by one.
    if type(count) in (int, float) and abs(count - video.frames) > 1:
        raise refuse(
            file,
            where,
            f"was drawn on {count:g} frames, {video.name} has {video.frames}: it is another video, or Label Studio "
            'counted at another rate. Set framerate="$fps" in the labelling configuration.',
        )


def _meta(region: dict[str, Any]) -> dict[str, list[str]]:
    """What ``meta.text`` says, lines ``name=value`` by name; others are notes."""
    meta = region.get("meta")
    lines = meta.get("text") if isinstance(meta, dict) else None
    out: dict[str, list[str]] = {}
    for line in [lines] if isinstance(lines, str) else _list(lines):
        name, equals, value = str(line).partition("=")
        known = bool(equals) and name in ("uid", "state", "source", "note")
        out.setdefault(name if known else "note", []).append(value if known else str(line))
    return out


def _number(key: dict[str, Any], name: str, file: str, where: str) -> float:
    value = key.get(name)
    if type(value) not in (int, float):
        raise refuse(file, where, f"{name} must be a number. Got {str(value)[:40]!r}.")
    try:
        return float(value)  # type: ignore[arg-type]
    except OverflowError:
        raise refuse(file, where, f"{name} is too large. Correct it.") from None


def _upright(x: float, y: float, width: float, height: float, turn: float) -> tuple[float, float, float, float]:
    """The upright box around a box that is turned about its upper left corner, by degrees clockwise."""
    cos, sin = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    corners = [(0.0, 0.0), (width, 0.0), (0.0, height), (width, height)]
    xs = [x + a * cos - b * sin for a, b in corners]
    ys = [y + a * sin + b * cos for a, b in corners]
    return min(xs), min(ys), max(xs) - min(xs), max(ys) - min(ys)


def _sniff(path: Path) -> bool:
    for file in _files(path)[:1] if path.is_dir() or path.suffix.lower() == ".json" else []:
        with file.open("rb") as stream:
            start = stream.read(1 << 16)
        return b'"videorectangle"' in start or (
            b'"data"' in start and (b'"annotations"' in start or b'"predictions"' in start)
        )
    return False


FORMAT = Format(
    name="label-studio",
    title="Label Studio video JSON",
    summary="Tracks with key frames for Label Studio's video rectangles; videos of constant frame rate only.",
    write=_write,
    read=_read,
    sniff=_sniff,
    export_switches=(
        Switch("as", ("predictions", "annotations"), "Suggestions to accept one by one, or finished annotations."),
    ),
    key_frames=True,
    docs="label-studio.md",
)
