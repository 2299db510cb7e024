"""Finds runs by the names that people give on the command line: run id, evidence folder or video."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from app.errors import ApiError, Invalid, StorageFull
from app.exchange.dataset import Source, evidence_source
from app.storage.ids import RUN_ID
from tsr_engine.errors import InputError, StorageError, TsrError, UsageError
from tsr_engine.evidence.schema import RUN_FILE
from tsr_engine.io.atomic import real_path


@contextmanager
def as_command_error() -> Iterator[None]:
    """Convert failures of the server's parts to errors of the command line, with their exit codes."""
    try:
        yield
    except ApiError as error:
        raise _command_error(error) from None


def _command_error(error: ApiError) -> TsrError:
    if isinstance(error, Invalid):
        return UsageError(error.message)
    return StorageError(error.message) if isinstance(error, StorageFull) else InputError(error.message)


def find_sources(
    names: Sequence[str], home: Path | None, video: Path | None, report: Callable[[str], None]
) -> list[Source]:
    """Find the runs of names.

    Args:
        names: each a run's 32 digits, an evidence folder, a video's file or its 64 digits; a video means its newest
            complete run.
        home: data folder of runs and videos.
        video: the file of a bare evidence folder.
        report: called with a sentence that says which run a video means.

    Raises:
        InputError: there is no such run, or it cannot be exported.
        UsageError: ``video`` with anything else than one bare evidence folder.
    """
    bare = {name for name in names if (Path(name) / RUN_FILE).is_file() and _data_folder_of(Path(name)) is None}
    if video is not None and (len(names) != 1 or not bare):
        raise UsageError("--video names the file of one evidence folder. Leave it out for runs of a data folder.")
    with as_command_error():
        return [
            _stored_source(name, home, report) if name not in bare else evidence_source(Path(name), video)
            for name in names
        ]


def track_key(text: str) -> str:
    """Convert a track as people write it (``7``, ``#7``, ``m7`` or the key of a drawn track) to its key."""
    number = text.strip().removeprefix("#")
    return f"m{number}" if number.isdecimal() else text.strip()


def _stored_source(name: str, home: Path | None, report: Callable[[str], None]) -> Source:
    """A run of a data folder."""
    from app.cli.data_folder import describe_run_choice, find_run, open_home  # slow because of the database
    from app.exchange.run_sources import run_source

    inside = _data_folder_of(Path(name))
    with open_home(home if inside is None else inside) as (settings, database), database.read() as session:
        run_id = Path(name).resolve().name if inside is not None else find_run(session, name)
        if run_id != Path(name).name:
            report(describe_run_choice(session, run_id))
        return run_source(session, settings, run_id)


def _data_folder_of(path: Path) -> Path | None:
    """The data folder that contains an evidence folder, and its corrections; None if it belongs to none."""
    folder = real_path(path)
    if not (folder / RUN_FILE).is_file() or not RUN_ID.fullmatch(folder.name) or folder.parent.name != "runs":
        return None
    from app.settings import DATABASE_FILE

    home = folder.parent.parent
    return home if (home / DATABASE_FILE).is_file() else None
