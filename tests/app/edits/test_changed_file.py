"""No edit is stored while the video's file is a different one. Without a file, work continues."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest
from pydantic import TypeAdapter
from sqlalchemy import func, select

from app.edits.commands import Command, Undo
from app.edits.documents import TrackDoc
from app.edits.views import EditAnswer
from app.errors import Conflict, NotFound
from app.storage.models import Edit, Run, Video
from tests.app.edits.edit_services import FRAMES, EditServices
from tsr_engine.io.digest import file_sha256
from tsr_engine.io.opened_file import OpenedFile
from tsr_engine.io.video_probe import video_sha256

ADAPTER: TypeAdapter[Any] = TypeAdapter(Command)
CONTENT = b"the bytes of a drive"
FIRST, SECOND = "c" * 32, "d" * 32


@pytest.fixture
def path(edits: EditServices, tmp_path: Path) -> Path:
    """The file of a video with two runs."""
    path = tmp_path / "drive.mp4"
    path.write_bytes(CONTENT)
    video = Video(
        id=video_sha256(path), name="d", path=str(path), size=len(CONTENT), warnings=[], state="ready", frames=FRAMES
    )
    with edits.database.write() as session:
        session.add(video)
        session.flush()
        for run in (FIRST, SECOND):
            session.add(Run(id=run, video_id=video.id, state="complete", parameters={}, models={}, summary={}))
    return path


def verdict(edits: EditServices, op: str = "op-00000001", track: str = "m1") -> EditAnswer:
    command = ADAPTER.validate_python({"name": "set_review", "frame": 3, "key": track, "review": "accepted"})
    return edits.service.apply(FIRST, op, "ann", command, {track: 0})


def count_edits(edits: EditServices) -> int:
    with edits.database.read() as session:
        return session.scalars(select(func.count(Edit.seq))).one()


@pytest.mark.parametrize("content", [b"other bytes, as many", b"cut"])
def test_edits_of_a_video_with_another_file_are_refused(edits: EditServices, path: Path, content: bytes) -> None:
    first = verdict(edits)
    path.write_bytes(content)
    os.utime(path, ns=(1, 1))
    drawn = ADAPTER.validate_python({"name": "create_track", "frame": 3, "key": "hdrawn01", "box": [1, 1, 20, 20]})
    document = TrackDoc(key="hdrawn02")
    for edit in (
        lambda: verdict(edits, "op-00000002", "m2"),
        lambda: edits.service.apply(FIRST, "op-00000003", "ann", drawn, {}),
        lambda: edits.service.apply(FIRST, "op-00000004", "ann", Undo(name="undo", op_id="op-00000001"), None),
        lambda: edits.bulk.adopt(SECOND, FIRST, "ann"),
        lambda: edits.bulk.put_documents(FIRST, "ann", {"name": "import"}, lambda _: {"hdrawn02": document}),
    ):
        with pytest.raises(Conflict, match=r"drive\.mp4 has changed since it was added\. Restore it") as refused:
            edit()
        assert refused.value.code == "file_changed"
    assert count_edits(edits) == 1
    assert verdict(edits).seq == first.seq, "its answer was lost on the way: it is stored"
    path.write_bytes(CONTENT)
    os.utime(path, ns=(2, 2))
    assert verdict(edits, "op-00000002", "m2").docs[0].review == "accepted"


def test_edits_without_a_file_are_stored(edits: EditServices, path: Path) -> None:
    path.unlink()
    assert verdict(edits).docs[0].review == "accepted"
    path.mkdir()
    assert verdict(edits, "op-00000002", "m2").docs[0].review == "accepted"


def test_a_touched_file_is_read_once(edits: EditServices, path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[Path] = []

    def counted(one: OpenedFile) -> str:
        read.append(one.path)
        return file_sha256(one.path)

    monkeypatch.setattr(OpenedFile, "sha256", counted)
    os.utime(path, ns=(1, 1))
    verdict(edits)
    verdict(edits, "op-00000002", "m2")
    assert read == [path]
    path.write_bytes(CONTENT.upper())
    os.utime(path, ns=(2, 2))
    for _ in range(2):
        with pytest.raises(Conflict):
            verdict(edits, "op-00000003", "m3")
    assert read == [path, path]


def test_an_unknown_run_is_refused_as_before(edits: EditServices) -> None:
    with pytest.raises(NotFound):
        edits.bulk.put_documents("e" * 32, "ann", {"name": "import"}, dict)
