"""Reads and writes versions of label sets, for code that has a session."""

from __future__ import annotations

import zlib
from datetime import datetime
from functools import lru_cache

from sqlalchemy import ColumnElement, Select, bindparam, func, select
from sqlalchemy.orm import Session

from app.errors import NotFound
from app.storage.lookup import require_video
from app.storage.models import LabelSetDefault, LabelSetVersion, Run
from tsr_engine.labels.changes import Changed
from tsr_engine.labels.files import DEFAULT, SHIPPED, dump_set, parse_set, shipped_set
from tsr_engine.labels.model import LabelSet

SET_KEY = r"^[a-z0-9][a-z0-9._-]{0,63}$"
"""Pattern of the key of a set."""
_SHIPPED_SENTENCE = "Came with tsr."


def _newest_document(key: ColumnElement[str]) -> Select[bytes]:
    versions = select(LabelSetVersion.document).where(LabelSetVersion.key == key)
    return versions.order_by(LabelSetVersion.version.desc()).limit(1)


# built once: building the query takes longer than running it
_OF_KEY = _newest_document(bindparam("key"))
_DEFAULT_KEY = select(LabelSetDefault.set_key).order_by(LabelSetDefault.seq.desc()).limit(1)
_default_or_shipped = func.coalesce(_DEFAULT_KEY.scalar_subquery(), DEFAULT)
_DEFAULT_SET = select(_default_or_shipped, _newest_document(_default_or_shipped).scalar_subquery())


def default_key(session: Session) -> str:
    """Key of the set of videos that name none."""
    return session.scalar(_DEFAULT_KEY) or DEFAULT


def set_keys(session: Session) -> list[str]:
    """Keys of all sets: those that ship with the package, then the library's own."""
    stored = session.scalars(select(LabelSetVersion.key).distinct().order_by(LabelSetVersion.key))
    return [*SHIPPED, *(key for key in stored if key not in SHIPPED)]


def newest(session: Session, key: str) -> LabelSet:
    """The newest version of a set.

    Raises:
        NotFound: there is no such set.
    """
    document = session.scalar(_OF_KEY, {"key": key})
    return _as_shipped(key) if document is None else _unpacked(document)


def _newest_default(session: Session) -> LabelSet:
    """The newest version of the set of videos that name none, in one query."""
    found, document = session.execute(_DEFAULT_SET).one()
    return _as_shipped(found) if document is None else _unpacked(document)


def at_version(session: Session, key: str, version: int) -> LabelSet:
    """One version of a set.

    Raises:
        NotFound: there is no such set or version.
    """
    row = session.get(LabelSetVersion, (key, version))
    if row is not None:
        return _unpacked(row.document)
    labels = newest(session, key)
    if labels.version != version:
        raise NotFound(f"The label set {key!r} has no version {version}.", field="version")
    return labels


def labels_of_video(session: Session, video_id: str) -> LabelSet:
    """The newest version of the set of a video: its own, or the library's default.

    Raises:
        NotFound: there is no such video.
    """
    video = require_video(session, video_id)
    return newest(session, video.label_set) if video.label_set else _newest_default(session)


def labels_of_run(session: Session, run: Run) -> LabelSet:
    """The newest version of the set of a run's video."""
    return labels_of_video(session, run.video_id)


def start(session: Session, labels: LabelSet, author: str, sentence: str) -> None:
    """Store the first version of a set."""
    _add(session, labels, author, sentence)


def append(session: Session, before: LabelSet, changed: Changed, author: str, undoes: int | None = None) -> None:
    """Store the next version of a set; the first change of a shipped set also stores its first version.

    If another person was faster, the next flush raises ``IntegrityError``, because the version exists already.
    """
    if before.version == 1 and session.get(LabelSetVersion, (before.key, 1)) is None:
        start(session, before, "", _SHIPPED_SENTENCE)
    _add(session, changed.labels, author, changed.sentence, undoes)
    session.flush()


def added_by(session: Session, key: str, label_id: int) -> tuple[str, datetime] | None:
    """Return who added a label, and when; None: it was in the first version."""
    first = select(LabelSetVersion).where(LabelSetVersion.key == key, LabelSetVersion.next_id > label_id)
    row = session.scalar(first.order_by(LabelSetVersion.version).limit(1))
    return None if row is None or row.version == 1 else (row.author, row.created)


def history(session: Session, key: str) -> list[LabelSetVersion]:
    """Return all versions, newest first; empty: a shipped set that was never changed.

    Raises:
        NotFound: no such set.
    """
    rows = select(LabelSetVersion).where(LabelSetVersion.key == key).order_by(LabelSetVersion.version.desc())
    found = list(session.scalars(rows))
    if not found:
        labels = _as_shipped(key)
        found = [
            LabelSetVersion(
                key=key, version=1, author="", sentence=_SHIPPED_SENTENCE, undoes=None, next_id=labels.next_id
            )
        ]
    return found


def _add(session: Session, labels: LabelSet, author: str, sentence: str, undoes: int | None = None) -> None:
    row = LabelSetVersion(key=labels.key, version=labels.version, author=author, sentence=sentence, undoes=undoes)
    row.next_id, row.document = labels.next_id, zlib.compress(dump_set(labels).encode(), 6)
    session.add(row)


@lru_cache(maxsize=32)
def _unpacked(document: bytes) -> LabelSet:
    return parse_set(zlib.decompress(document), "The stored label set")


def _as_shipped(key: str) -> LabelSet:
    try:
        return shipped_set(key)
    except KeyError:
        raise NotFound(f"There is no label set {key[:80]!r}.", field="set") from None
