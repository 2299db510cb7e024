"""Edits on both databases, over toy tracks."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from app.edits.service import EditService
from app.events import EventBus
from app.storage.database import Database
from app.storage.models import Base, Run, Video

RUN, OTHER = "a" * 32, "b" * 32


@dataclass
class ToyEvidence:
    """What the service asks of evidence."""

    spans: dict[int, tuple[int, int]] = field(default_factory=lambda: {1: (0, 20), 2: (15, 40), 3: (50, 70)})

    def span(self, _run_id: str, track: int) -> tuple[int, int] | None:
        return self.spans.get(track)


@dataclass
class Desk:
    """A service with one complete run."""

    database: Database
    service: EditService
    evidence: ToyEvidence
    run: str = RUN


def make_desk(url: str) -> Desk:
    """A service on a fresh database."""
    database = Database(url)
    Base.metadata.create_all(database.engine)
    with database.write() as session:
        session.add(Video(id="f" * 64, name="v", path="/v", size=1, warnings=[]))
        session.flush()
        session.add(Run(id=RUN, video_id="f" * 64, state="complete", parameters={}, models={}, summary={}))
    evidence = ToyEvidence()
    return Desk(database, EditService(database, EventBus(), evidence), evidence)  # type: ignore[arg-type]


@pytest.fixture(scope="session")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A PostgreSQL of this session's own, on a socket; skips where there is none."""
    initdb, pg_ctl = shutil.which("initdb"), shutil.which("pg_ctl")
    if initdb is None or pg_ctl is None:
        pytest.skip("PostgreSQL is not installed")
    import getpass
    import os
    import tempfile

    user = "nobody" if getpass.getuser() == "root" else None
    folder = Path(tempfile.mkdtemp(prefix="tsr-pg"))
    if user is not None:
        shutil.chown(folder, user)
    data = folder / "data"
    quiet = {
        "check": True,
        "stdout": subprocess.DEVNULL,
        "cwd": folder,
        "user": user,
        "env": {**os.environ, "HOME": str(folder)},
    }
    subprocess.run([initdb, "-D", data, "-U", "tsr", "-A", "trust", "--no-sync"], **quiet)  # type: ignore[call-overload]
    options = f"-k {folder} -c listen_addresses=''"
    subprocess.run([pg_ctl, "start", "-w", "-D", data, "-o", options, "-l", folder / "log"], **quiet)  # type: ignore[call-overload]
    yield f"postgresql+psycopg://tsr@/postgres?host={folder}"
    subprocess.run([pg_ctl, "stop", "-m", "immediate", "-D", data], **quiet)  # type: ignore[call-overload]
    shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(params=["sqlite", "postgresql"])
def desk(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Desk]:
    """A service with one complete run, on each kind of database."""
    if request.param == "sqlite":
        made = make_desk(f"sqlite:///{tmp_path / 'tsr.sqlite'}")
    else:
        url = request.getfixturevalue("cluster")
        wipe = Database(url)
        Base.metadata.drop_all(wipe.engine)
        wipe.close()
        made = make_desk(url)
    yield made
    made.database.close()
