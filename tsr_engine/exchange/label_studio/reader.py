"""Reads Label Studio's video JSON: finds the task of the video and reads its regions."""

from __future__ import annotations

import csv
from pathlib import Path

from tsr_engine.exchange.dataset import Dataset, DatasetVideo
from tsr_engine.exchange.file_listing import head_of
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.label_studio.controls import answers_of, declare_controls
from tsr_engine.exchange.label_studio.regions import TimeCheck, as_list, is_rectangle, read_region, target_object
from tsr_engine.exchange.reading import read_json, rule_error
from tsr_engine.exchange.split import SUBSETS
from tsr_engine.exchange.video_matching import VideoPart, choose_parts, name_in, name_similarity
from tsr_engine.json_shapes import JsonObject

TASK_FILES = ("tasks.json", *(f"tasks_{name}.json" for name in SUBSETS))
_NON_ADDRESS_KEYS = frozenset({"video", "sha256", "subset"})
"""Keys of a task that are not addresses of its video."""
_TABLE_COLUMNS = frozenset({"annotation_id", "annotator", "lead_time"})
"""Columns of Label Studio's CSV and TSV, which are also the keys of JSON-MIN."""
_JSON_ADVICE = "Export as JSON, not JSON-MIN or CSV."


def read_label_studio(path: Path, target: ImportTarget) -> Dataset:
    """Read a file or folder of tasks.

    Raises:
        ImportFormatError: a task breaks a rule.
    """
    video = target.video
    if not video.constant_rate or video.rate is None:
        raise rule_error(
            path.name,
            None,
            f"counts frames by time, but {video.name} has a variable frame rate, so its frames differ. Use CVAT.",
        )
    validator = ImportValidator(target)
    files = _files(path)
    if not files:
        raise rule_error(path.name, None, "has no JSON file. Export as JSON from Label Studio again.")
    parts = [part for file in files for part in _tasks(file, video)]
    declare_controls(path if path.is_dir() else path.parent, validator)
    # The subsets of a split are tasks of one video, which name it by its hash.
    merge = all(part.is_match is not None for part in parts)
    for part in choose_parts(parts, validator, files[0].name if len(files) == 1 else path.name, "task", merge=merge):
        task, file_name, where = part.content
        if not part.name and part.is_match is None:
            validator.repair(
                f"{file_name}, {where}: does not say which video it is about. It was imported onto {video.name}."
            )
        _read_task(task, validator, file_name, where)
    return validator.finish(files[0].name, interpolate=True)


def _files(path: Path) -> list[Path]:
    if path.is_file():
        return [path]
    own_files = [path / name for name in TASK_FILES if (path / name).is_file()]
    return own_files or sorted(file for file in path.glob("*.json") if file.name != "manifest.json")


def _tasks(file: Path, video: DatasetVideo) -> list[VideoPart[tuple[JsonObject, str, str]]]:
    if file.suffix.lower() != ".json":
        raise rule_error(
            file.name, None, f"is a table of Label Studio, which lacks a part of the annotations. {_JSON_ADVICE}"
        )
    tasks = read_json(file)
    tasks = [tasks] if isinstance(tasks, dict) else tasks
    if not isinstance(tasks, list) or not all(isinstance(task, dict) for task in tasks):
        raise rule_error(file.name, None, f"must be a list of tasks. {_JSON_ADVICE}")
    parts = []
    for position, task in enumerate(tasks, start=1):
        if "data" not in task and "annotations" not in task and "predictions" not in task:
            raise rule_error(
                file.name, f"task {position}", f"has no data and no annotations, as in JSON-MIN. {_JSON_ADVICE}"
            )
        parts.append(_part(task, file.name, f"task {position}", video))
    return parts


def _part(task: JsonObject, file: str, where: str, video: DatasetVideo) -> VideoPart[tuple[JsonObject, str, str]]:
    """A task and the video that it is about: by our hash if there is one, else by the addresses in its data."""
    data = task.get("data")
    data = data if isinstance(data, dict) else {}
    digest = data.get("sha256")
    # In most projects, ``to_name`` of a region is the key of the address of its video.
    targets = {name for answer in _annotations(task) for region in answer["result"] if (name := target_object(region))}
    values = [data.get(name) for name in sorted(targets)]
    if not any(isinstance(value, str) for value in values):
        values = [data.get("video"), *(value for key, value in data.items() if key not in _NON_ADDRESS_KEYS)]
    addresses = [value for value in values if isinstance(value, str)]
    upload = task.get("file_upload")
    if isinstance(upload, str):
        addresses.append(f"/upload/{upload}")
    return VideoPart(
        (task, file, where),
        tuple(addresses),
        ids=(str(task["id"]),) if isinstance(task.get("id"), (int, str)) else (),
        is_match=digest == video.sha256 if digest and video.sha256 else None,
    )


def _annotations(task: JsonObject) -> list[JsonObject]:
    return [
        answer
        for kind in ("annotations", "predictions")
        for answer in as_list(task.get(kind))
        if isinstance(answer, dict) and not answer.get("was_cancelled") and isinstance(answer.get("result"), list)
    ]


def _left_out_reason(answers: list[JsonObject]) -> str:
    have_rectangles = [any(map(is_rectangle, answer["result"])) for answer in answers]
    empty = "; it has no video rectangles, and others have" if any(have_rectangles) and not have_rectangles[0] else ""
    return f"Only the first annotation of a task is imported{empty}."


def _read_task(task: JsonObject, validator: ImportValidator, file: str, where: str) -> None:
    answers = _annotations(task)
    if not answers:
        raise rule_error(file, where, "has neither annotations nor predictions with a result. Export as JSON again.")
    if len(answers) > 1:
        validator.skip(f"{file}, {where}: {len(answers) - 1} annotations", _left_out_reason(answers))
    annotations = [answer for answer in as_list(task.get("annotations")) if isinstance(answer, dict)]
    if annotations and all(answer.get("was_cancelled") for answer in annotations):
        validator.repair(f"{file}, {where}: was skipped in Label Studio, so its prediction was imported.")
    other_videos = _other_videos(task, answers[0]["result"], validator.target.video)
    labels = {
        region.get("id"): as_list(region["value"].get("labels"))
        for region in answers[0]["result"]
        if isinstance(region, dict)
        and region.get("type") == "labels"
        and isinstance(region.get("value"), dict)
        and isinstance(region.get("id"), str)
    }
    answers_by_region = answers_of(answers[0]["result"])
    rectangle_ids = {region.get("id") for region in answers[0]["result"] if is_rectangle(region)}
    times = TimeCheck(validator, file, where)
    other_results = 0
    for index, region in enumerate(answers[0]["result"]):
        region_location = f"{where}, region {index + 1}"
        if not isinstance(region, dict):
            raise rule_error(file, region_location, "must be an object. Correct it.")
        if not is_rectangle(region):
            is_known = region.get("type") == "labels" or str(region.get("id")) in answers_by_region
            other_results += not (is_known and region.get("id") in rectangle_ids)
            continue
        if target_object(region) in other_videos:
            validator.skip(f"{file}, {region_location}", f"It is drawn on {other_videos[target_object(region)]}.")
            continue
        attributes = answers_by_region.get(str(region.get("id")), {})
        read_region(region, labels.get(str(region.get("id")), []), attributes, times, validator, file, region_location)
    times.report((task.get("data") or {}).get("fps") if isinstance(task.get("data"), dict) else None)
    if other_results:
        validator.skip(f"{file}, {where}: {other_results} results", "They are not video rectangles.")


def _other_videos(task: JsonObject, regions: list[object], video: DatasetVideo) -> dict[str, str]:
    """Other videos that regions of a task are drawn on: key -> name."""
    data = task.get("data")
    targets = {name for region in regions if (name := target_object(region))}
    found = {name: data[name] for name in targets if isinstance(data, dict) and isinstance(data.get(name), str)}
    of_video = {name for name, address in found.items() if name_similarity(address, video)}
    return {name: name_in(address) for name, address in found.items() if of_video and name not in of_video}


def sniff_label_studio(path: Path) -> bool:
    """Whether the path is, or holds, an export of Label Studio.

    Unreadable files count, so that the reader can report them.
    """
    for file in _files(path)[:1] if path.is_dir() else [path]:
        start = head_of(file, 1 << 16)
        if file.suffix.lower() in (".csv", ".tsv"):
            head = start.split(b"\n", 1)[0].decode("utf-8-sig", "replace").strip()
            return any(set(next(csv.reader([head], delimiter=mark), [])) >= _TABLE_COLUMNS for mark in ",\t")
        if file.suffix.lower() != ".json" or b'"tsr-tracks"' in start:
            return False
        is_task = b'"data"' in start and (b'"annotations"' in start or b'"predictions"' in start)
        is_minimal_form = (b'"annotation_id"' in start and b'"annotator"' in start) or b'"framesCount"' in start
        return b'"videorectangle"' in start or is_task or is_minimal_form
    return False
