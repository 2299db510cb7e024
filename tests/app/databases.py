"""Both kinds of database for tests: SQLite always, PostgreSQL where its server is installed."""

from __future__ import annotations

import getpass
import os
import shutil
import subprocess
import tempfile
import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import create_engine

from app.storage.database import Database

__all__ = ["cluster", "database", "database_url", "new_database"]


@pytest.fixture(scope="session")
def cluster() -> Iterator[str]:
    """A PostgreSQL of this session's own, on a socket; skips where there is none."""
    initdb, pg_ctl = shutil.which("initdb"), shutil.which("pg_ctl")
    if initdb is None or pg_ctl is None:
        pytest.skip("PostgreSQL is not installed")
    user = "nobody" if getpass.getuser() == "root" else None
    folder = Path(tempfile.mkdtemp(prefix="tsr-pg"))
    if user is not None:
        shutil.chown(folder, user)
    data = folder / "data"

    def do(*command: object) -> None:
        subprocess.run(
            [str(part) for part in command],
            check=True,
            stdout=subprocess.DEVNULL,
            cwd=folder,
            user=user,
            env={**os.environ, "HOME": str(folder)},
        )

    do(initdb, "-D", data, "-U", "tsr", "-A", "trust", "--no-sync")
    options = f"-k {folder} -c listen_addresses=''"
    do(pg_ctl, "start", "-w", "-D", data, "-o", options, "-l", folder / "log")
    yield f"postgresql+psycopg://tsr@/postgres?host={folder}"
    do(pg_ctl, "stop", "-m", "immediate", "-D", data)
    shutil.rmtree(folder, ignore_errors=True)


def new_database(cluster: str) -> str:
    """Address of an empty database of its own."""
    name = f"t{uuid.uuid4().hex}"
    engine = create_engine(cluster, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.exec_driver_sql(f"CREATE DATABASE {name}")
    engine.dispose()
    return cluster.replace("/postgres?", f"/{name}?")


@pytest.fixture(params=["sqlite", "postgresql"])
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Address of an empty database."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'tsr.sqlite'}"
    return new_database(request.getfixturevalue("cluster"))


@pytest.fixture
def database(database_url: str) -> Iterator[Database]:
    """An empty database with its tables."""
    made = Database(database_url)
    made.migrate()
    yield made
    made.close()
