"""Reads the tasks in the ``<meta>`` of a CVAT file: one task, a job of one, or all tasks of a project.

A project's file numbers the frames of its tasks one after the other. Each task begins after the end of those before it,
and each subset begins at 0 again (``_init_task_frame_offsets`` in CVAT's ``dataset_manager/bindings.py``).
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from tsr_engine.exchange.cvat.common import original_scale
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.reading import rule_error
from tsr_engine.exchange.video_matching import VideoPart, choose_parts
from tsr_engine.exchange.xml import Node
from tsr_engine.io.plain_numbers import parse_whole

_STEP = re.compile(r"\s*step\s*=\s*(\d{1,9})\s*", re.ASCII)


@dataclass(frozen=True, slots=True)
class Task:
    """One task.

    Attributes:
        id: CVAT's id.
        name: the name that people see.
        source: file name of its video; empty: not stated.
        step: the task holds every ``step``-th frame of the video, >= 1.
        stop: its last frame in the video; None: not stated.
        offset: added by the file to the frames of the task's video.
        size: ``<original_size>``; None: missing.
        project: whether the file is of a project, where tracks name their task.
    """

    id: str
    name: str
    source: str
    step: int
    stop: int | None
    offset: int
    size: Node | None
    project: bool


def tasks_of(meta: Node, file: str) -> list[Task]:
    """The tasks of a ``<meta>`` element in their order; a job counts as one task.

    Raises:
        ImportFormatError: a number of a project's task is not a whole number.
    """
    project = meta.child("project")
    task_nodes = project.child("tasks") if project is not None else None
    nodes = (
        list(task_nodes.all("task"))
        if task_nodes is not None
        else [node for node in meta.children if node.tag in ("task", "job")]
    )
    parents = [node for node in (meta, project) if node is not None]
    common = {
        tag: next(filter(None, (node.child(tag) for node in parents)), None) for tag in ("original_size", "source")
    }
    tasks: list[Task] = []
    subset, begin = "", 0
    for node in nodes:
        step = _STEP.fullmatch(node.value("frame_filter"))
        stride = max(int(step[1]), 1) if step else 1
        if node.value("subset") != subset:
            subset, begin = node.value("subset"), 0
        common_source = common["source"]
        source = node.value("source") or (common_source.text if common_source is not None else "")
        size = node.child("original_size") or common["original_size"]
        tasks.append(
            Task(node.value("id"), node.value("name"), source, stride, _stop(node), begin, size, task_nodes is not None)
        )
        if task_nodes is not None and len(nodes) > 1:
            begin += _whole(node, "start_frame", file) + stride * _whole(node, "size", file)
    return tasks


class VideoTask:
    """The task of a file that is about the video of an import."""

    def __init__(self, meta: Node, validator: ImportValidator, file: str) -> None:
        """Choose the task, and report what is left out.

        Raises:
            ImportFormatError: no task is about the video, two are, or its pictures have another size.
        """
        self._tasks = tasks_of(meta, file)
        parts = [
            VideoPart(task, (task.source or task.name,), ids=tuple(filter(None, (task.id, task.name))))
            for task in self._tasks
        ]
        found = choose_parts(parts, validator, file, "task")
        self.task = found[0].content if found else Task("", "", "", 1, None, 0, meta.child("original_size"), False)
        """The task; without a source and a size of its own if the file has none."""
        frames, stop = validator.target.video.frames, self.task.stop
        if stop is not None and stop >= frames:
            validator.repair(
                f"{file}: its task ends with frame {stop}, {validator.target.video.name} with {frames - 1}."
            )
        if self.task.step > 1:
            validator.repair(
                f"{file}: its task has one of {self.task.step} frames of the video. Boxes in the frames between were "
                "interpolated, and a track ends in the last frame that shows it."
            )
        self._task_id = ""
        self.other_count = 0
        """Number of elements of other tasks."""
        self.scale = (1.0, 1.0) if self.task.size is None else original_scale(self.task.size, validator, file)

    def includes(self, node: Node, file: str) -> bool:
        """Whether a track or picture is of the task; ``other_count`` counts those that are not.

        Raises:
            ImportFormatError: it names no task, or one that the file does not have.
        """
        task_id = node.attrib.get("task_id", "")
        if not self.task.project:
            self._task_id = self._task_id or task_id
            if task_id and task_id != self._task_id:
                rule = (
                    f"it is of task {task_id[:20]}, elements before of task {self._task_id[:20]}, and no <tasks> tell "
                    "of both"
                )
                raise rule_error(file, node.line, f"{rule}. Export the task of this video alone.")
            return True
        if task_id not in {task.id for task in self._tasks} and (task_id or len(self._tasks) > 1):
            rule = f"task_id {task_id[:20]!r} matches no task" if task_id else "it has no task_id"
            raise rule_error(file, node.line, f"{rule} of the project. Export the task of this video alone.")
        if task_id and task_id != self.task.id:
            self.other_count += 1
            return False
        return True


def _stop(node: Node) -> int | None:
    stop = node.value("stop_frame")
    return int(stop) if stop.isascii() and stop.isdigit() and len(stop) < 10 else None


def _whole(node: Node, name: str, file: str) -> int:
    text = node.value(name)
    try:
        value = parse_whole(text) if len(text) < 10 else None
    except ValueError:
        value = None
    if value is None:
        rule = f"<{name}> of a task must be a whole number, as later tasks are numbered by it. Correct it."
        raise rule_error(file, node.line, rule)
    return value
