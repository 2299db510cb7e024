"""Reads Label Studio's video JSON: which task is about the video, and its regions."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from tsr_engine.exchange.checks import ImportValidator, read_json, refuse
from tsr_engine.exchange.dataset import UNSAID, Dataset, DatasetVideo
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.label_studio.controls import answers_of, declare_controls
from tsr_engine.exchange.notes import notes_from_text
from tsr_engine.exchange.split import SUBSETS
from tsr_engine.exchange.subject import Part, choose, name_in, name_similarity

__all__ = ["FILES", "read_label_studio", "sniff_label_studio"]

FILES = ("tasks.json", *(f"tasks_{name}.json" for name in SUBSETS))
_OTHER = frozenset({"video", "sha256", "subset"})
"""Keys of a task that are no further addresses."""
_TABLE = frozenset({"annotation_id", "annotator", "lead_time"})
"""Columns of Label Studio's CSV and TSV, which are keys of JSON-MIN."""
_JSON = "Export as JSON, not JSON-MIN or CSV."


def read_label_studio(path: Path, target: ImportTarget) -> Dataset:
    """Read a file or folder.

    Raises:
        ImportFormatError: a broken rule.
    """
    video = target.video
    if not video.constant_rate or video.rate is None:
        raise refuse(
            path.name,
            None,
            f"counts frames by time, but {video.name} has a variable frame rate, so its frames are others. Use CVAT.",
        )
    validator = ImportValidator(target)
    files = _files(path)
    if not files:
        raise refuse(path.name, None, "has no JSON file. Export as JSON from Label Studio again.")
    parts = [part for file in files for part in _tasks(file, video)]
    declare_controls(path if path.is_dir() else path.parent, validator)
    for part in choose(
        parts, validator, files[0].name if len(files) == 1 else path.name, "task", merge=_are_ours(parts)
    ):
        task, file_name, where = part.content
        if not part.name and part.known is None:
            validator.repair(
                f"{file_name}, {where}: does not say which video it is about. It was taken for {video.name}."
            )
        _read_task(task, validator, file_name, where)
    return validator.finish(files[0].name, interpolate=True)


def _files(path: Path) -> list[Path]:
    if path.is_file():
        return [path]
    ours = [path / name for name in FILES if (path / name).is_file()]
    return ours or sorted(file for file in path.glob("*.json") if file.name != "manifest.json")


def _tasks(file: Path, video: DatasetVideo) -> list[Part[tuple[dict[str, Any], str, str]]]:
    if file.suffix.lower() != ".json":
        raise refuse(file.name, None, f"is a table of Label Studio, which does not say all of a video. {_JSON}")
    tasks = read_json(file)
    tasks = [tasks] if isinstance(tasks, dict) else tasks
    if not isinstance(tasks, list) or not all(isinstance(task, dict) for task in tasks):
        raise refuse(file.name, None, f"must be a list of tasks. {_JSON}")
    parts = []
    for place, task in enumerate(tasks, start=1):
        if "data" not in task and "annotations" not in task and "predictions" not in task:
            raise refuse(file.name, f"task {place}", f"has no data and no annotations, as in JSON-MIN. {_JSON}")
        parts.append(_part(task, file.name, f"task {place}", video))
    return parts


def _part(task: dict[str, Any], file: str, where: str, video: DatasetVideo) -> Part[tuple[dict[str, Any], str, str]]:
    """A task with what it says of its video: by the hash where we wrote it, else by the addresses in its data."""
    data = task.get("data")
    data = data if isinstance(data, dict) else {}
    digest = data.get("sha256")
    # What a region is drawn on is called as the key of its address in most projects.
    drawn_on = {name for answer in _answers(task) for region in answer["result"] if (name := _drawn_on(region))}
    values = [data.get(name) for name in sorted(drawn_on)]
    if not any(isinstance(value, str) for value in values):
        values = [data.get("video"), *(value for key, value in data.items() if key not in _OTHER)]
    addresses = [value for value in values if isinstance(value, str)]
    upload = task.get("file_upload")
    if isinstance(upload, str):
        addresses.append(f"/upload/{upload}")
    return Part(
        (task, file, where),
        tuple(addresses),
        ids=(str(task["id"]),) if isinstance(task.get("id"), (int, str)) else (),
        known=digest == video.sha256 if digest and video.sha256 else None,
    )


def _are_ours(parts: list[Part[tuple[dict[str, Any], str, str]]]) -> bool:
    """Whether all that are about the video say so by its hash: the sides of a split are tasks of one video."""
    return all(part.known is not None for part in parts)


def _answers(task: dict[str, Any]) -> list[dict[str, Any]]:
    return [
        answer
        for kind in ("annotations", "predictions")
        for answer in _list(task.get(kind))
        if isinstance(answer, dict) and not answer.get("was_cancelled") and isinstance(answer.get("result"), list)
    ]


def _left(answers: list[dict[str, Any]]) -> str:
    drawn = [any(map(_is_rectangle, answer["result"])) for answer in answers]
    empty = "; it has no video rectangles, and others have" if any(drawn) and not drawn[0] else ""
    return f"Only the first of a task is taken{empty}."


def _drawn_on(region: Any) -> str:
    name = region.get("to_name") if isinstance(region, dict) else None
    return name if isinstance(name, str) else ""


def _read_task(task: dict[str, Any], validator: ImportValidator, file: str, where: str) -> None:
    answers = _answers(task)
    if not answers:
        raise refuse(file, where, "has neither annotations nor predictions with a result. Export as JSON again.")
    if len(answers) > 1:
        validator.skip(f"{file}, {where}: {len(answers) - 1} annotations", _left(answers))
    elsewhere = _others(task, answers[0]["result"], validator.target.video)
    labels = {
        region.get("id"): _list(region["value"].get("labels"))
        for region in answers[0]["result"]
        if isinstance(region, dict)
        and region.get("type") == "labels"
        and isinstance(region.get("value"), dict)
        and isinstance(region.get("id"), str)
    }
    answers_by_region = answers_of(answers[0]["result"])
    drawn = {region.get("id") for region in answers[0]["result"] if _is_rectangle(region)}
    times = _Times(validator, file, where)
    other = 0
    for place, region in enumerate(answers[0]["result"]):
        spot = f"{where}, region {place + 1}"
        if not isinstance(region, dict):
            raise refuse(file, spot, "must be an object. Correct it.")
        if not _is_rectangle(region):
            known = region.get("type") == "labels" or str(region.get("id")) in answers_by_region
            other += not (known and region.get("id") in drawn)
            continue
        if _drawn_on(region) in elsewhere:
            validator.skip(f"{file}, {spot}", f"It is drawn on {elsewhere[_drawn_on(region)]}.")
            continue
        said = answers_by_region.get(str(region.get("id")), {})
        _read_region(region, labels.get(str(region.get("id")), []), said, times, validator, file, spot)
    times.settle((task.get("data") or {}).get("fps") if isinstance(task.get("data"), dict) else None)
    if other:
        validator.skip(f"{file}, {where}: {other} results", "They are no video rectangles.")


def _is_rectangle(region: Any) -> bool:
    return isinstance(region, dict) and region.get("type") == "videorectangle"


class _Times:
    """Holds the times of key frames against their numbers, which Label Studio makes of them at its own rate."""

    def __init__(self, validator: ImportValidator, file: str, where: str) -> None:
        self._validator = validator
        self._file = file
        self._where = where
        self._rate = float(validator.target.video.rate or 0)
        self._seen = 0
        self._wrong: list[str] = []
        self._first = ""
        self._early = 0

    def look(self, frame: int, time: Any, spot: str) -> None:
        """One key frame: its time is that of its number from 1, or of its ordinal."""
        if type(time) not in (int, float):
            return
        self._seen += 1
        self._early += abs(time * self._rate - frame) < 0.25
        # Half a frame on either side: times are rounded, and some are those of the player.
        if not frame - 0.5 <= time * self._rate <= frame + 1.5:
            self._wrong.append(spot)
            self._first = self._first or f"frame {frame + 1} is at {time:g} s"

    def settle(self, fps: Any) -> None:
        """Tell of what contradicts.

        Raises:
            ImportFormatError: most times are those of other frames.
        """
        video, rate = self._validator.target.video, f"{self._rate:g} frames/s"
        if len(self._wrong) * 2 > self._seen:
            raise refuse(
                self._file,
                self._wrong[0],
                f"{self._first}, but {video.name} has {rate}: it is another video, or Label Studio counted at another "
                'rate. Set framerate="$fps" in the labelling configuration.',
            )
        if self._early * 2 > self._seen:
            reported = "key frames were taken by their number, from 1; their times begin at 0"
            self._validator.repair(f"{self._file}, {self._where}: {reported}.")
        for spot in self._wrong:
            self._validator.count(
                "Key frames were taken by their number; their time is that of another", self._file, spot
            )
        if type(fps) in (int, float) and abs(fps - self._rate) > 0.01 * self._rate:
            self._validator.repair(f"{self._file}, {self._where}: says {fps:g} frames/s, {video.name} has {rate}.")


def _others(task: dict[str, Any], regions: list[Any], video: DatasetVideo) -> dict[str, str]:
    """What regions of a task with several videos are drawn on that is not the video: key -> name."""
    data = task.get("data")
    known = {name for region in regions if (name := _drawn_on(region))}
    found = {name: data[name] for name in known if isinstance(data, dict) and isinstance(data.get(name), str)}
    about = {name for name, address in found.items() if name_similarity(address, video)}
    return {name: name_in(address) for name, address in found.items() if about and name not in about}


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []


def _read_region(
    region: dict[str, Any],
    labels: list[Any],
    said: Mapping[str, Any],
    times: _Times,
    validator: ImportValidator,
    file: str,
    where: str,
) -> None:
    value = region.get("value")
    if not isinstance(value, dict) or not isinstance(value.get("sequence"), list):
        raise refuse(file, where, "must have a value with a sequence. Export as JSON again.")
    _check_count(value.get("framesCount"), validator, file, where)
    names = _list(value.get("labels")) or labels
    label = validator.label(str(names[0]), file, where) if names else UNSAID
    if len(names) != 1:
        kind = "Regions of several labels have the first one" if names else "Regions have no label"
        validator.count(kind, file, where)
    meta = _meta(region)
    uid = validator.unique((meta.get("uid") or [str(region.get("id", ""))])[0].strip() or where, file, where)
    video = validator.target.video
    enabled_at: dict[int, bool] = {}
    for place, key in enumerate(value["sequence"]):
        spot = f"{where}, key frame {place + 1}"
        if not isinstance(key, dict):
            raise refuse(file, spot, "must be an object. Correct it.")
        frame = validator.frame(key.get("frame", ""), file, spot, origin=1)
        times.look(frame, key.get("time"), spot)
        edges = validator.edges(partial(_edges, key, validator, file, spot))
        if validator.box(uid, frame, edges, label, file=file, line=spot):
            enabled_at[frame] = key.get("enabled", True) is not False
    for frame, enabled in enabled_at.items():
        if not enabled and frame + 1 not in enabled_at:
            validator.end(uid, frame + 1)
    if enabled_at and not any(isinstance(key, dict) and "enabled" in key for key in value["sequence"]):
        validator.count(
            "Regions without enabled do not say where they end; they were shown to the last frame", file, where
        )
    validator.describe(
        uid,
        state=(meta.get("state") or ["open"])[0],
        source=(meta.get("source") or ["imported"])[0],
        notes=notes_from_text("\n".join(meta.get("note", [])), min(enabled_at, default=0)),
        said=said,
        # Enabled at its last key frame, a region stays to the end of the video.
        until=video.frames - 1 if enabled_at and enabled_at[max(enabled_at)] else -1,
    )


def _edges(key: dict[str, Any], validator: ImportValidator, file: str, where: str) -> tuple[float, float, float, float]:
    video = validator.target.video
    x, y, width, height = (
        _number(key, name, file, where) / 100 * side
        for name, side in (("x", video.width), ("y", video.height), ("width", video.width), ("height", video.height))
    )
    turn = _number(key, "rotation", file, where) if key.get("rotation") else 0.0
    if turn % 360 and math.isfinite(turn):
        x, y, width, height = _upright(x, y, width, height, turn)
        validator.count("Turned boxes were replaced by the upright boxes around them", file, where)
    return x, y, x + width, y + height


def _check_count(count: Any, validator: ImportValidator, file: str, where: str) -> None:
    video = validator.target.video
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


def sniff_label_studio(path: Path) -> bool:
    """Whether it is, or has, an export of Label Studio.

    Those that cannot be read count, so that they can be reported.
    """
    for file in _files(path)[:1] if path.is_dir() else [path]:
        with file.open("rb") as stream:
            start = stream.read(1 << 16)
        if file.suffix.lower() in (".csv", ".tsv"):
            head = start.split(b"\n", 1)[0].decode("utf-8-sig", "replace").strip()
            return any(set(next(csv.reader([head], delimiter=mark), [])) >= _TABLE for mark in ",\t")
        if file.suffix.lower() != ".json" or b'"tsr-tracks"' in start:
            return False
        whole = b'"data"' in start and (b'"annotations"' in start or b'"predictions"' in start)
        least = (b'"annotation_id"' in start and b'"annotator"' in start) or b'"framesCount"' in start
        return b'"videorectangle"' in start or whole or least
    return False
