"""Tasks and projects of CVAT for video: which task, video and picture size a file is about."""

from __future__ import annotations

import tracemalloc

import pytest

from tests.exchange.cvat_files import BOX, SAMPLE, Read, cvat_file, cvat_track
from tests.exchange.small_datasets import tracks_of
from tsr_engine.errors import ImportFormatError

TASK = (
    "<task><id>{id}</id><name>{name}</name><size>{size}</size><mode>interpolation</mode><subset>{subset}</subset>"
    "<start_frame>{start}</start_frame><stop_frame>{stop}</stop_frame><frame_filter>{filter}</frame_filter>"
    "<original_size><width>{width}</width><height>360</height></original_size><source>{source}</source></task>"
)


def _task(id: int, source: str, **more: object) -> str:
    fields = {"name": source.rsplit(".", 1)[0], "size": 100, "subset": "default", "start": 0, "stop": 99}
    return TASK.format(**{**fields, "filter": "", "width": 640, "id": id, "source": source, **more})


def _project(*tasks: str, tracks: dict[int, tuple[int, ...]], said: str = ' task_id="{}"') -> str:
    """A project's file; ``tracks`` has the frames of each task's track, in the numbers of the file."""
    rows = "".join(
        f'<track id="{index}" label="stop"{said.format(task)}>'
        + "".join(BOX.format(frame, 1, int(frame == frames[-1]), 20) for frame in frames)
        + "</track>\n"
        for index, (task, frames) in enumerate(tracks.items())
    )
    return f"<annotations><meta><project><tasks>\n{''.join(tasks)}</tasks></project></meta>\n{rows}</annotations>"


@pytest.mark.parametrize(
    ("before", "offset"),
    [
        ({"size": 40}, 40),
        ({"size": 20, "filter": "step=5"}, 100),
        ({"size": 20, "start": 7, "filter": "step = 5"}, 107),
        ({"size": 40, "subset": "train"}, 0),
        ({"size": 40, "width": 1280}, 40),
        ({"size": 40, "stop": "9" * 5000}, 40),
        ({"size": 40, "filter": f"step={'9' * 5000}"}, 40),
    ],
)
def test_a_project_gives_the_task_of_the_video(read_file: Read, before: dict[str, object], offset: int) -> None:
    tasks = _task(1, "other.mp4", **before), _task(2, "drive.mp4")
    content = _project(*tasks, tracks={1: (3, 8), 2: (offset + 10, offset + 16)})
    found = read_file(content)
    (track,) = tracks_of(found).values()
    assert track.frames.tolist() == list(range(10, 16))
    assert found.repaired == ()
    assert [(item.what, item.reason) for item in found.skipped] == [
        ("annotations.xml: 1 task", "They are not about drive.mp4: 1 (other.mp4)."),
        ("annotations.xml: 1 track", "They are of other tasks."),
    ]
    if offset < 40:
        again = read_file(content, task="1")
        assert tracks_of(again)["cvat-0"].frames.tolist() == list(range(3, 8))
        assert "names other.mp4" in again.repaired[0]


@pytest.mark.parametrize(
    ("tasks", "tracks", "said", "rule"),
    [
        (("rear-drive.mp4", "other.mp4"), {1: (3, 8)}, ' task_id="{}"',
         r"2 tasks, none about drive\.mp4: 1 \(rear-drive\.mp4\), 2 \(other\.mp4\).*task=ID"),
        (("drive.mp4", "drive.mp4"), {1: (3, 8)}, ' task_id="{}"', r"has 2 tasks that fit drive\.mp4.*task=ID"),
        (("other.mp4", "drive.mp4"), {2: (39, 41)}, ' task_id="{}"', "frame 39 must be in 100 to 199"),
        (("other.mp4", "drive.mp4"), {7: (3, 8)}, ' task_id="{}"', "task_id '7' matches no task"),
        (("other.mp4", "drive.mp4"), {1: (3, 8)}, "", "it has no task_id"),
    ],
)  # fmt: skip
def test_refusals_of_projects(
    read_file: Read, tasks: tuple[str, ...], tracks: dict[int, tuple[int, ...]], said: str, rule: str
) -> None:
    with pytest.raises(ImportFormatError, match=rf"^annotations\.xml.*{rule}"):
        read_file(_project(*(_task(index, name) for index, name in enumerate(tasks, 1)), tracks=tracks, said=said))


@pytest.mark.parametrize("field", ["size", "start"])
def test_numbers_of_thousands_of_digits_are_refused(read_file: Read, field: str) -> None:
    tasks = _task(1, "other.mp4", **{field: "9" * 4300, "filter": "step=5"}), _task(2, "drive.mp4")
    with pytest.raises(ImportFormatError, match=f"<{field}.*> of a task must be a whole number"):
        read_file(_project(*tasks, tracks={2: (3, 8)}))


def test_a_large_step_takes_no_memory(read_file: Read) -> None:
    content = _project(_task(1, "drive.mp4", filter="step=300000"), tracks={1: (3, 8)})
    tracemalloc.start()
    try:
        (track,) = tracks_of(read_file(content)).values()
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert track.frames.tolist() == list(range(3, 8))
    assert peak < 10e6


def test_tracks_of_two_tasks_without_tasks_are_refused(read_file: Read) -> None:
    content = _project(tracks={1: (3, 8), 2: (43, 48)})
    for text in (content, content.replace("<meta><project><tasks>\n</tasks></project></meta>", "")):
        with pytest.raises(ImportFormatError, match="it is of task 2, elements before of task 1"):
            read_file(text)
    assert tracks_of(read_file(_project(tracks={1: (3, 8)})))["cvat-0"].frames[0] == 3


def test_a_task_of_a_project_is_chosen_by_id_or_name(read_file: Read) -> None:
    content = _project(_task(1, "a/drive.mp4"), _task(2, "b/drive.mp4", name="rear"), tracks={1: (3, 8), 2: (104, 109)})
    assert tracks_of(read_file(content, task="1"))["cvat-0"].frames[0] == 3
    assert tracks_of(read_file(content, task="2"))["cvat-1"].frames[0] == 4
    assert tracks_of(read_file(content, task="rear"))["cvat-1"].frames[0] == 4


@pytest.mark.parametrize(
    ("meta", "reported"),
    [
        (_task(1, "drive.mp4"), None),
        (_task(1, "/home/django/data/drive.mp4"), None),
        (_task(1, "other.mp4", name="drive"), "names other.mp4"),
        ("<task><name>drive</name></task><source>other.mp4</source>", "names other.mp4"),
        ("<task><name>elsewhere</name></task>", "names elsewhere"),
        (_task(1, "drive.mp4", stop=400), "its task ends with frame 400, drive.mp4 with 99"),
        (f"<project><tasks>{_task(1, 'other.mp4')}</tasks></project>", "names other.mp4"),
    ],
)
def test_a_file_of_another_video_is_reported(read_file: Read, meta: str, reported: str | None) -> None:
    found = read_file(SAMPLE.replace("<task><mode>", f"{meta}<x><mode>").replace("</task></meta>", "</x></meta>"))
    assert tracks_of(found)["t-7f3a"].frames[0] == 10
    assert len(found.repaired) == (reported is not None)
    assert reported is None or reported in found.repaired[0]


@pytest.mark.parametrize(
    "meta",
    [
        "<job><id>1</id><mode>interpolation</mode></job>{}",
        "<job><id>1</id><mode>interpolation</mode>{}</job>",
        "<task><id>1</id></task>{}",
        "<project><tasks><task><id>1</id><size>9</size>{}</task></tasks></project>",
        "<project><tasks><task><id>1</id></task></tasks></project>{}",
        "<project><tasks><task><id>1</id></task></tasks>{}</project>",
        "{}",
    ],
)
def test_the_size_is_found_in_every_place(read_file: Read, meta: str) -> None:
    size = "<original_size><width>{}</width><height>{}</height></original_size>"
    track = cvat_track(BOX.format(3, 1, 0, 20), BOX.format(4, 1, 1, 20))
    assert read_file(cvat_file(f"<meta>{meta.format(size.format(640, 360))}</meta>", track)).repaired == ()
    with pytest.raises(ImportFormatError, match="has a picture size of 320x180 px"):
        read_file(cvat_file(f"<meta>{meta.format(size.format(320, 180))}</meta>", track))
