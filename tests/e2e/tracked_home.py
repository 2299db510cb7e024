"""Data folders with one video. A clip is imported and tracked once for all tests; each server gets a copy."""

from __future__ import annotations

import fcntl
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import pytest

from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Run, Video
from tests.e2e.forked_server import ForkedServer

__all__ = ["TrackedHome", "tracked_home"]

SERVER_FILES = shutil.ignore_patterns("*.lock", "server.log", "token")
"""Files of a running server, which a copy of the data folder lacks."""


class TrackedHome(NamedTuple):
    """A data folder, the folder with its video, and the ids of the video and its run, empty without one."""

    home: Path
    roots: Path
    video: str
    run: str


def tracked_home(
    folders: pytest.TempPathFactory, clip: Path, stop: int | None, name: str = "drive.mp4", run: str | None = None
) -> TrackedHome:
    """A new data folder with a clip and one complete run over its beginning.

    Args:
        folders: where the folder is created.
        clip: the video.
        stop: frame after the last one of the run; None: there is no run.
        name: of the video.
        run: name of the run; None: the server's default.
    """
    kept = _shared(folders) / f"tracked-{clip.stem}-{stop}"
    with _locked(kept.with_suffix(".lock")):
        if not (kept / "ids").is_file():
            shutil.rmtree(kept, ignore_errors=True)
            _track(kept, clip, stop)
    video, _, tracked = (kept / "ids").read_text().partition(" ")
    home = TrackedHome(folders.mktemp("home"), kept / "clips", video, tracked)
    shutil.copytree(kept / "home", home.home, ignore=SERVER_FILES, dirs_exist_ok=True)
    database = Database(Settings(home=home.home).database)
    with database.write() as session:
        session.get_one(Video, home.video).name = name
        if run is not None:
            session.get_one(Run, home.run).name = run
    database.close()
    return home


def _shared(folders: pytest.TempPathFactory) -> Path:
    """A folder shared by all processes of this test run."""
    own = folders.getbasetemp()
    return own.parent if "PYTEST_XDIST_WORKER" in os.environ else own


@contextmanager
def _locked(lock: Path) -> Iterator[None]:
    """Admit one process at a time."""
    with lock.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _track(folder: Path, clip: Path, stop: int | None) -> None:
    """Let a server import a clip and track it; the file ``ids`` is written when all is done."""
    roots, home = folder / "clips", folder / "home"
    roots.mkdir(parents=True)
    home.mkdir()
    shutil.copyfile(clip, roots / "drive.mp4")
    with ForkedServer(home, roots=(roots,), sample=False) as server:
        video = str(server.add_video(roots / "drive.mp4")["id"])
        run = "" if stop is None else server.track(video, {"stop": stop})
    (folder / "ids").write_text(f"{video} {run}")
