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
from tests.app.exchange.exchange_client import ExchangeClient, zipped
from tests.invalid_archives import ARCHIVE_FAULTS, archive_of_empty_files
from tsr_engine.errors import StorageError
from tsr_engine.exchange.archive import ArchiveLimits


def state(api: ExchangeClient) -> tuple[int, int, int, list[str]]:
    """Runs, ground truths, edits, and the files of runs and uploads."""
    with api.server.context.database.read() as session:
        runs, ground_truths = session.query(Run).count(), session.query(GroundTruth).count()
    edits = len(api.get(f"/api/runs/{api.run_id}/edits")["edits"])
    files = [path.name for folder in ("runs", "uploads") for path in (api.home / folder).glob("*")]
    return runs, ground_truths, edits, sorted(files)


REFUSED: dict[str, tuple[Any, dict[str, Any], str]] = {
    "frame": (lambda text: text.replace(b'frame="30"', b'frame="3000"'), {}, "must be in 0 to 74"),
    "nan": (lambda text: text.replace(b'xtl="', b'xtl="nan', 1), {}, "line"),
    "cut": (lambda text: text[: len(text) // 2], {}, ""),
    "nothing": (lambda _: b"hello", {}, "matches none of"),
    "half an archive": (lambda text: zipped({"annotations.xml": text})[:-40], {}, "whose end is missing"),
    **{
        name: (lambda text, change=change: change(zipped({"annotations.xml": text})), {}, "the archive is damaged")
        for name, change in ARCHIVE_FAULTS.items()
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
def test_an_invalid_file_changes_nothing(read_only_api: ExchangeClient, annotations: bytes, name: str) -> None:
    api = read_only_api
    change, query, words = REFUSED[name]
    before = state(api)
    for kind in ("truth", "run", "annotation"):
        answer = api.send_import(change(annotations), kind, **{"name": "bad.xml", **query})
        assert answer.status_code == 422, answer.text
        error = answer.json()["error"]
        assert words in error["message"]
        assert "Traceback" not in error["message"]
        assert state(api) == before


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
def test_hostile_and_too_large_files_have_their_own_statuses(
    read_only_api: ExchangeClient, annotations: bytes, name: str
) -> None:
    change, status, words = HOSTILE[name]
    before = state(read_only_api)
    for kind in ("truth", "run", "annotation"):
        answer = read_only_api.send_import(change(annotations), kind, name="bad.xml")
        error = answer.json()["error"]
        assert (answer.status_code, error["code"]) == (status, "bad_file"), answer.text
        assert words in error["message"]
        assert error["message"].endswith("Nothing was imported.")
        assert state(read_only_api) == before


def test_a_directory_over_the_limit_is_not_read_by_the_server(
    read_only_api: ExchangeClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken_apart: set[str] = set()

    class Noted(zipfile.ZipInfo):
        def __init__(self, name: str = "", *more: Any) -> None:
            taken_apart.add(name)
            super().__init__(name, *more)

    content = archive_of_empty_files(ArchiveLimits().entries + 1)
    monkeypatch.setattr(zipfile, "ZipInfo", Noted)
    answer = read_only_api.send_import(content, "run", name="long.zip")
    assert answer.status_code == 413, answer.text
    assert "400001 entries" in answer.json()["error"]["message"]
    assert "x" not in taken_apart


def test_an_annotation_needs_a_run_of_this_video(read_only_api: ExchangeClient, annotations: bytes) -> None:
    api = read_only_api
    url = f"/api/videos/{api.video_id}/imports"
    for query, status in (({"as": "annotation"}, 422), ({"as": "annotation", "run": "0" * 32}, 404)):
        answer = api.server.client.post(url, params=query, content=annotations)
        assert answer.status_code == status, answer.text
    answer = api.server.client.post(f"/api/videos/{'0' * 64}/imports", params={"as": "run"}, content=annotations)
    assert answer.status_code == 404


def test_a_body_over_the_limit_is_refused(read_only_api: ExchangeClient, monkeypatch: pytest.MonkeyPatch) -> None:
    api = read_only_api
    settings = api.server.context.settings.model_copy(update={"upload_max_mb": 1})
    monkeypatch.setattr(type(api.server.context), "settings", settings, raising=False)
    before = state(api)
    answer = api.send_import(b"x" * (2**20 + 1), "truth", name="big.xml")
    assert answer.status_code == 413
    assert state(api) == before


def test_larger_bodies_than_usual_are_accepted(read_only_api: ExchangeClient, annotations: bytes) -> None:
    api = read_only_api
    padded = annotations + b"\n" * (api.server.settings.body_max_kb * 1024 + 10)
    assert api.import_file(padded, "truth", name="padded.xml")["tracks"] == 2


def test_a_full_disk_while_a_run_is_written_leaves_nothing(
    api: ExchangeClient, annotations: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = state(api)

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("tsr_engine.evidence.writer.add_rows", full)
    with pytest.raises((OSError, StorageError)):
        api.import_inline(annotations, "run", "full.xml")
    assert state(api) == before


def test_leftovers_of_a_killed_import_are_removed(read_only_api: ExchangeClient) -> None:
    api = read_only_api
    imports: ImportService = api.server.context.imports
    left = [api.home / "runs" / ".import-1", imports.new_part()]
    left[0].mkdir()
    (left[0] / "run.lock").write_bytes(b"")
    imports.sweep()
    assert not any(path.exists() for path in left)
    assert (api.home / "runs" / api.run_id).is_dir()


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


def test_a_kill_between_files_and_commit_leaves_nothing(
    api: ExchangeClient, annotations: bytes, tmp_path: Path
) -> None:
    before = state(api)
    file = tmp_path / "theirs.xml"
    file.write_bytes(annotations)
    done = subprocess.run(
        [sys.executable, "-c", KILLED, str(api.home), api.video_id, str(file)],
        stderr=subprocess.PIPE, timeout=500, check=False,
    )  # fmt: skip
    assert done.returncode == -signal.SIGKILL, done.stderr.decode()
    assert state(api) != before, "the test must leave something to clean up"
    sweep(api.home, api.server.context.database)
    assert state(api) == before


def test_files_of_a_running_import_are_kept(read_only_api: ExchangeClient) -> None:
    api = read_only_api
    import fcntl

    folder = api.home / "runs" / ".import-2"
    folder.mkdir()
    with Path(folder / "run.lock").open("wb") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        api.server.context.imports.sweep()
        assert folder.is_dir()
    api.server.context.imports.sweep()
    assert not folder.exists()
