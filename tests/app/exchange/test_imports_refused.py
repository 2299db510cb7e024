"""Imports over HTTP that are refused or interrupted change nothing and leave nothing behind."""

from __future__ import annotations

import errno
import io
import signal
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import pytest

from app.exchange.imports import ImportService
from app.outputs.file_moves import sweep
from app.storage.models import GroundTruth, Run
from tests.app.exchange.exchange_desk import Desk, zipped
from tests.odd_archives import ODD, long_list
from tsr_engine.errors import StorageError
from tsr_engine.exchange.archive import ArchiveLimits


def state(desk: Desk) -> tuple[int, int, int, list[str]]:
    """Runs, ground truths, edits, and the files of runs and uploads."""
    with desk.server.context.database.read() as session:
        runs, ground_truths = session.query(Run).count(), session.query(GroundTruth).count()
    edits = len(desk.get(f"/api/runs/{desk.run_id}/edits")["edits"])
    files = [path.name for folder in ("runs", "uploads") for path in (desk.home / folder).glob("*")]
    return runs, ground_truths, edits, sorted(files)


REFUSED: dict[str, tuple[Any, dict[str, Any], str]] = {
    "frame": (lambda text: text.replace(b'frame="30"', b'frame="3000"'), {}, "must be in 0 to 74"),
    "nan": (lambda text: text.replace(b'xtl="', b'xtl="nan', 1), {}, "line"),
    "cut": (lambda text: text[: len(text) // 2], {}, ""),
    "nothing": (lambda _: b"hello", {}, "matches none of"),
    "half an archive": (lambda text: zipped({"annotations.xml": text})[:-40], {}, "whose end is missing"),
    **{
        name: (lambda text, change=change: change(zipped({"annotations.xml": text})), {}, "the archive is damaged")
        for name, change in ODD.items()
    },
    "a bug bundle": (
        lambda _: zipped(dict.fromkeys(("README.txt", "manifest.json", "frames.csv", "output.csv", "clip.mp4"), b"x")),
        {},
        "is a bug bundle",
    ),
    "nested": (lambda text: zipped({"a.zip": zipped({"annotations.xml": text})}), {}, ""),
    "other format": (lambda text: text, {"format": "label-studio"}, ""),
    "no format": (lambda text: text, {"format": "papyrus"}, "There is no format"),
    "option": (lambda text: text, {"format": "cvat-video", "switches": '{"a": "b"}'}, "no option 'a'"),
    "option of nothing": (lambda text: text, {"switches": '{"a": "b"}'}, "name it with format="),
    "switches": (lambda text: text, {"switches": "[1]"}, "must be a JSON object"),
    "labels": (lambda text: text, {"label_map": '{"stop": [1]}'}, "must be a JSON object"),
    "class": (lambda text: text, {"label_map": '{"stop": 99}'}, "99"),
    "empty": (lambda _: b"", {}, "empty"),
}


@pytest.mark.parametrize("name", list(REFUSED))
def test_an_invalid_file_changes_nothing(untouched: Desk, annotations: bytes, name: str) -> None:
    desk = untouched
    change, query, words = REFUSED[name]
    before = state(desk)
    for kind in ("truth", "run", "annotation"):
        answer = desk.try_import(change(annotations), kind, **{"name": "bad.xml", **query})
        assert answer.status_code == 422, answer.text
        error = answer.json()["error"]
        assert words in error["message"]
        assert "Traceback" not in error["message"]
        assert state(desk) == before


def deflated(content: bytes) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("annotations.xml", content)
    return out.getvalue()


HOSTILE: dict[str, tuple[Any, int, str]] = {
    "entity": (lambda text: b'<!DOCTYPE a [<!ENTITY e "x">]>' + text.split(b"?>", 1)[-1], 400, "DOCTYPE"),
    "entity of an archive": (
        lambda _: zipped({"annotations.xml": b'<!DOCTYPE a SYSTEM "file:///etc/passwd"><annotations/>'}),
        400,
        "DOCTYPE",
    ),
    "traversal": (lambda text: zipped({"annotations.xml": text, "../../evil": b"x"}), 400, "leads out of its folder"),
    "absolute": (lambda text: zipped({"annotations.xml": text, "/evil": b"x"}), 400, "absolute name"),
    "ratio": (lambda _: deflated(b"\0" * (8 << 20)), 413, "times its packed size"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_and_too_large_files_have_their_own_statuses(untouched: Desk, annotations: bytes, name: str) -> None:
    change, status, words = HOSTILE[name]
    before = state(untouched)
    for kind in ("truth", "run", "annotation"):
        answer = untouched.try_import(change(annotations), kind, name="bad.xml")
        error = answer.json()["error"]
        assert (answer.status_code, error["code"]) == (status, "bad_file"), answer.text
        assert words in error["message"]
        assert error["message"].endswith("Nothing was imported.")
        assert state(untouched) == before


def test_a_directory_over_the_limit_is_not_read_by_the_server(untouched: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    taken_apart: set[str] = set()

    class Noted(zipfile.ZipInfo):
        def __init__(self, name: str = "", *more: Any) -> None:
            taken_apart.add(name)
            super().__init__(name, *more)

    content = long_list(ArchiveLimits().entries + 1)
    monkeypatch.setattr(zipfile, "ZipInfo", Noted)
    answer = untouched.try_import(content, "run", name="long.zip")
    assert answer.status_code == 413, answer.text
    assert "400001 entries" in answer.json()["error"]["message"]
    assert "x" not in taken_apart


def test_an_annotation_needs_a_run_of_this_video(untouched: Desk, annotations: bytes) -> None:
    desk = untouched
    url = f"/api/videos/{desk.video_id}/imports"
    for query, status in (({"as": "annotation"}, 422), ({"as": "annotation", "run": "0" * 32}, 404)):
        answer = desk.server.client.post(url, params=query, content=annotations)
        assert answer.status_code == status, answer.text
    answer = desk.server.client.post(f"/api/videos/{'0' * 64}/imports", params={"as": "run"}, content=annotations)
    assert answer.status_code == 404


def test_a_body_over_the_limit_is_refused(untouched: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    desk = untouched
    settings = desk.server.context.settings.model_copy(update={"upload_max_mb": 1})
    monkeypatch.setattr(type(desk.server.context), "settings", settings, raising=False)
    before = state(desk)
    answer = desk.try_import(b"x" * (2**20 + 1), "truth", name="big.xml")
    assert answer.status_code == 413
    assert state(desk) == before


def test_larger_bodies_than_usual_are_accepted(untouched: Desk, annotations: bytes) -> None:
    desk = untouched
    padded = annotations + b"\n" * (desk.server.settings.body_max_kb * 1024 + 10)
    assert desk.bring_in(padded, "truth", name="padded.xml")["tracks"] == 2


def test_a_full_disk_while_a_run_is_written_leaves_nothing(
    desk: Desk, annotations: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = state(desk)

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("tsr_engine.evidence.writer.add_rows", full)
    with pytest.raises((OSError, StorageError)):
        desk.bring_in_here(annotations, "run", "full.xml")
    assert state(desk) == before


def test_leftovers_of_a_killed_import_are_removed(untouched: Desk) -> None:
    desk = untouched
    imports: ImportService = desk.server.context.imports
    left = [desk.home / "runs" / ".import-1", imports.new_part()]
    left[0].mkdir()
    (left[0] / "run.lock").write_bytes(b"")
    imports.sweep()
    assert not any(path.exists() for path in left)
    assert (desk.home / "runs" / desk.run_id).is_dir()


# A process that imports a run and dies by SIGKILL between the last file and the commit.
KILLED = """
import os, signal, sys
from pathlib import Path
from app.outputs import file_moves
from app.context import build_context
from app.exchange.import_file import ImportFile
from app.settings import Settings
put = file_moves.FileMoves.move
def put_and_die(self, source, place):
    put(self, source, place)
    os.kill(os.getpid(), signal.SIGKILL)
file_moves.FileMoves.move = put_and_die
home, video, file = sys.argv[1:]
build_context(Settings(home=Path(home))).imports.import_file(video, ImportFile(Path(file), "late"), "run")
"""


def test_a_kill_between_files_and_commit_leaves_nothing(desk: Desk, annotations: bytes, tmp_path: Path) -> None:
    before = state(desk)
    file = tmp_path / "theirs.xml"
    file.write_bytes(annotations)
    done = subprocess.run(
        [sys.executable, "-c", KILLED, str(desk.home), desk.video_id, str(file)],
        stderr=subprocess.PIPE, timeout=500, check=False,
    )  # fmt: skip
    assert done.returncode == -signal.SIGKILL, done.stderr.decode()
    assert state(desk) != before, "the test must leave something to clean up"
    sweep(desk.home, desk.server.context.database)
    assert state(desk) == before


def test_files_of_a_running_import_are_kept(untouched: Desk) -> None:
    desk = untouched
    import fcntl

    folder = desk.home / "runs" / ".import-2"
    folder.mkdir()
    with Path(folder / "run.lock").open("wb") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        desk.server.context.imports.sweep()
        assert folder.is_dir()
    desk.server.context.imports.sweep()
    assert not folder.exists()
