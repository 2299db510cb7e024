"""Objects are stored in and read from the shared files completely; every failure is one sentence."""

from __future__ import annotations

import errno
import json
import socket
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.files import store as store_module
from app.files.shared import SharedFiles
from app.files.store import SharedFilesError, SharedStore
from app.settings import Settings
from tsr_engine.errors import StorageError


@pytest.fixture(params=["folder", "s3"])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> SharedStore:
    if request.param == "folder":
        (tmp_path / "mounted").mkdir()
    made = SharedStore(
        f"file://{tmp_path / 'mounted'}" if request.param == "folder" else request.getfixturevalue("bucket")
    )
    made.store_id(None)
    return made


@pytest.fixture
def run(tmp_path: Path) -> Path:
    folder = tmp_path / "run"
    (folder / "more").mkdir(parents=True)
    (folder / "evidence.sqlite").write_bytes(bytes(range(256)) * 999)
    (folder / "evidence.sqlite-shm").write_bytes(b"of readers")
    (folder / "evidence.sqlite-wal").write_bytes(b"")
    (folder / "run.lock").write_bytes(b"")
    (folder / "more" / "run.json").write_text("{}")
    return folder


def test_a_folder_round_trips(store: SharedStore, run: Path, tmp_path: Path) -> None:
    number = store.store_id(None)
    assert store.store_id(number) == number
    assert set(store.put("runs/1", run)) == {"evidence.sqlite", "more/run.json"}
    assert store.is_complete("runs/1")
    store.get("runs/1", store.list_files("runs/1"), tmp_path / "back")
    assert (tmp_path / "back" / "evidence.sqlite").read_bytes() == (run / "evidence.sqlite").read_bytes()
    assert (tmp_path / "back" / "more" / "run.json").read_text() == "{}"
    store.put("videos/1", run / "evidence.sqlite")
    store.get("videos/1", store.list_files("videos/1"), tmp_path / "video")
    assert (tmp_path / "video").read_bytes() == (run / "evidence.sqlite").read_bytes()
    store.remove("runs/1")
    store.remove("runs/1")
    with pytest.raises(SharedFilesError, match=r"no longer hold runs/1"):
        store.list_files("runs/1")
    assert store.is_complete("videos/1"), "only what was named is gone"


def test_damaged_objects_are_refused(store: SharedStore, run: Path, tmp_path: Path) -> None:
    store.put("runs/1", run)
    files = store.list_files("runs/1")
    store.system.pipe_file(store.path("runs/1", "evidence.sqlite"), bytes(256 * 999))
    with pytest.raises(SharedFilesError, match=r"runs/1/evidence.sqlite in the shared files .* is damaged") as damaged:
        store.get("runs/1", files, tmp_path / "back")
    assert damaged.value.code == "files_damaged"
    for text in (b"[]", b'{"files": {"../x": [1, "a"]}}', b'{"files": {"x": 1}}', b"\xff"):
        store.system.pipe_file(store.path("runs/1.json"), text)
        with pytest.raises(SharedFilesError, match=r"runs/1.json .* is damaged"):
            store.list_files("runs/1")


def test_other_files_than_those_known_are_refused(store: SharedStore) -> None:
    number = store.store_id(None)
    with pytest.raises(StorageError, match=r"does not hold the shared files that this server knows"):
        store.store_id("0" * 32)
    store.system.rm(store.path("store.id"))
    with pytest.raises(StorageError, match=r"store.id is missing"):
        store.store_id(number)


def test_an_unmounted_folder_is_reported(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match=r"folder .*away.* does not exist. Make it, or mount it"):
        SharedStore(str(tmp_path / "away")).store_id(None)


def test_a_full_folder_keeps_no_partial_object(run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mounted").mkdir()
    store = SharedStore(str(tmp_path / "mounted"))
    store.store_id(None)

    def full(_source: str, place: str) -> None:
        Path(place).write_bytes(b"half")
        raise OSError(errno.ENOSPC, "No space left on device", place)

    monkeypatch.setattr(store.system, "put_file", full)
    with pytest.raises(SharedFilesError, match=r"are full. Free some space there"):
        store.put("runs/1", run)
    assert [path.name for path in (tmp_path / "mounted").rglob("*") if path.is_file()] == ["store.id"]


def test_a_missing_bucket_is_reported(s3: str) -> None:
    with pytest.raises(StorageError, match=r"there is no such bucket. Make it, or correct TSR_FILES"):
        SharedStore("s3://tsr-not-there/x").store_id(None)


@pytest.fixture
def strict(s3: str) -> Iterator[None]:
    """Make the S3 server check credentials for a while."""
    for count in (b"0", b"inf"):
        urllib.request.urlopen(
            urllib.request.Request(f"{s3}/moto-api/reset-auth", count, {"Content-Type": "text/plain"})
        ).close()
        if count == b"0":
            yield


def test_wrong_credentials_are_reported(bucket: str, strict: None) -> None:
    with pytest.raises(SharedFilesError, match=r"deny access. Check this server's rights, and for S3"):
        SharedStore(bucket).store_id(None)


@pytest.mark.parametrize("listens", [True, False])
def test_an_unreachable_s3_is_reported(s3: str, listens: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    quick = {"connect_timeout": 0.2, "read_timeout": 0.2, "retries": {"max_attempts": 1}}
    monkeypatch.setattr(store_module, "S3_LIMITS", quick)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        port = silent.getsockname()[1]
        if not listens:
            silent.close()
        monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{port}")
        with pytest.raises(SharedFilesError, match=r"do not answer") as away:
            SharedStore("s3://tsr-bucket/x").store_id(None)
    assert (away.value.status, away.value.code) == (503, "files_away")
    assert json.dumps(away.value.body())


def test_a_silent_s3_is_noticed_while_others_wait_for_it(s3: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store_module, "PROBE_LIMITS", {**store_module.PROBE_LIMITS, "read_timeout": 0.2})
    SharedStore("s3://tsr-not-there/x").require_answer()  # a place without its id answers too
    with socket.create_server(("127.0.0.1", 0)) as silent:
        monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{silent.getsockname()[1]}")
        began = time.monotonic()
        with pytest.raises(SharedFilesError, match=r"do not answer"):
            SharedStore("s3://tsr-bucket/x").require_answer()
    assert time.monotonic() - began < store_module.S3_LIMITS["read_timeout"]  # type: ignore[operator]


def test_removed_entries_leave_no_local_copy(store: SharedStore, tmp_path: Path) -> None:
    settings = Settings(home=tmp_path / "home", files=store.address, database_url="postgresql://x/y")
    files, name = SharedFiles(store, settings), f"videos/{'0' * 64}"
    path = settings.home / name
    path.parent.mkdir(parents=True)
    path.write_bytes(b"fetched")
    files.record_copy(name, path, 7)
    files.remove_in_background(name)
    assert not path.exists()
    assert files.local_copies() == []


def test_the_start_of_a_server_does_not_wait_for_a_silent_s3(
    bucket: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = Settings(home=tmp_path, files=bucket, database_url="postgresql://x/y")
    assert SharedFiles(SharedStore(bucket), settings).prepare() is None
    monkeypatch.setattr(store_module, "PROBE_LIMITS", {**store_module.PROBE_LIMITS, "read_timeout": 0.2})
    with socket.create_server(("127.0.0.1", 0)) as silent:
        monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{silent.getsockname()[1]}")
        began = time.monotonic()
        assert "do not answer" in str(SharedFiles(SharedStore(bucket), settings).prepare())
    assert time.monotonic() - began < store_module.S3_LIMITS["read_timeout"]  # type: ignore[operator]
