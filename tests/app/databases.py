"""Databases for tests: SQLite always, PostgreSQL if it is installed.

The tables are created once per process and kind; each test gets a copy.
"""

from __future__ import annotations

import getpass
import os
import shutil
import subprocess
import tempfile
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import pytest
from sqlalchemy import create_engine, make_url

from app.storage.database import Database


class Cluster:
    """A separate PostgreSQL on a socket.

    Attributes:
        url: of its first database.
    """

    def __init__(self, folder: Path, user: str | None, pg_ctl: str) -> None:
        self._folder, self._user, self._pg_ctl = folder, user, pg_ctl
        self.url = f"postgresql+psycopg://tsr@/postgres?host={folder}"

    def do(self, *command: object) -> None:
        """Run one of its programs."""
        subprocess.run(
            [str(part) for part in command],
            check=True,
            stdout=subprocess.DEVNULL,
            cwd=self._folder,
            user=self._user,
            env={**os.environ, "HOME": str(self._folder)},
        )

    def start(self) -> None:
        """Start it and wait until it answers. A crash of the process loses nothing; a crash of the machine may."""
        options = f"-k {self._folder} -c listen_addresses='' -c fsync=off -c wal_level=minimal -c max_wal_senders=0"
        log = self._folder / "log"
        self.do(self._pg_ctl, "start", "-w", "-D", self._folder / "data", "-o", options, "-l", log)

    def stop(self, mode: str = "immediate") -> None:
        """Stop it: ``fast`` informs the clients, ``immediate`` is like a crash."""
        self.do(self._pg_ctl, "stop", "-m", mode, "-D", self._folder / "data")


def _memory_folder() -> Path | None:
    """A folder in memory with enough room: hundreds of databases have 300 files each. None: there is none."""
    folder = Path("/dev/shm")
    return folder if folder.is_dir() and shutil.disk_usage(folder).free > 2**31 else None


@contextmanager
def running_cluster() -> Iterator[Cluster]:
    """A PostgreSQL for a block; skips if it is not installed."""
    initdb, pg_ctl = shutil.which("initdb"), shutil.which("pg_ctl")
    if initdb is None or pg_ctl is None:
        pytest.skip("PostgreSQL is not installed")
    user = "nobody" if getpass.getuser() == "root" else None
    folder = Path(tempfile.mkdtemp(prefix="tsr-pg", dir=_memory_folder()))
    if user is not None:
        shutil.chown(folder, user)
    made = Cluster(folder, user, pg_ctl)
    made.do(initdb, "-D", folder / "data", "-U", "tsr", "-A", "trust", "--no-sync")
    made.start()
    try:
        yield made
    finally:
        made.stop()
        shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(scope="session")
def cluster() -> Iterator[str]:
    """Address of this session's PostgreSQL."""
    with running_cluster() as made:
        yield made.url


def new_database(cluster: str, *, bare: bool = False) -> str:
    """Address of a new PostgreSQL database with empty tables; bare: without tables."""
    name = f"t{uuid.uuid4().hex}"
    template = "" if bare else f" TEMPLATE {_template(cluster)} STRATEGY FILE_COPY"
    _command(cluster, f"CREATE DATABASE {name}{template}")
    return cluster.replace("/postgres?", f"/{name}?")


@contextmanager
def _lent_database(cluster: str, *, bare: bool) -> Iterator[str]:
    """One that is dropped at the end: hundreds of them are gigabytes, which a disk takes a minute to discard."""
    url = new_database(cluster, bare=bare)
    yield url
    _command(cluster, f"DROP DATABASE {make_url(url).database} WITH (FORCE)")


def _command(cluster: str, text: str) -> None:
    engine = create_engine(cluster, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.exec_driver_sql(text)
    engine.dispose()


@cache
def _template(cluster: str) -> str:
    url = new_database(cluster, bare=True)
    _migrate(url)
    return str(make_url(url).database)


def put_tables(file: Path) -> None:
    """Create a SQLite file with empty tables."""
    file.write_bytes(_sqlite())


@cache
def _sqlite() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "tsr.sqlite"
        _migrate(f"sqlite:///{file}")
        return file.read_bytes()


def _migrate(url: str) -> None:
    made = Database(url)
    made.migrate()
    made.close()


@pytest.fixture(params=["sqlite", "postgresql"])
def bare_database_url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """Address of a database without tables."""
    if request.param == "sqlite":
        yield f"sqlite:///{tmp_path / 'tsr.sqlite'}"
        return
    with _lent_database(request.getfixturevalue("cluster"), bare=True) as url:
        yield url


@pytest.fixture(params=["sqlite", "postgresql"])
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """Address of a database with empty tables."""
    if request.param == "sqlite":
        put_tables(tmp_path / "tsr.sqlite")
        yield f"sqlite:///{tmp_path / 'tsr.sqlite'}"
        return
    with _lent_database(request.getfixturevalue("cluster"), bare=False) as url:
        yield url


@pytest.fixture
def database(database_url: str) -> Iterator[Database]:
    """An empty database with its tables."""
    database = Database(database_url)
    yield database
    database.close()
