"""Tables of label sets; part of ``app.storage.models``."""

from __future__ import annotations

from datetime import datetime

from sqlalchemy import BigInteger, Integer, LargeBinary, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from app.storage.base import Base, Sequence, now
from app.storage.utc_times import UtcDateTime


class LabelSetVersion(Base):
    """One immutable version of a label set. A set that ships with the package has rows only after its first change."""

    __tablename__ = "label_sets"

    key: Mapped[str] = mapped_column(String(64), primary_key=True)
    version: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=False)
    author: Mapped[str] = mapped_column(Text)
    """Author; empty: the first version, from the package or a file."""
    sentence: Mapped[str] = mapped_column(Text)
    """Description of the change."""
    undoes: Mapped[int | None]
    """The version whose change it undid."""
    next_id: Mapped[int] = mapped_column(BigInteger)
    """First unused id; shows which version added a label."""
    document: Mapped[bytes] = mapped_column(LargeBinary, deferred=True)
    """The set in our file format, deflated."""
    created: Mapped[datetime] = mapped_column(UtcDateTime, default=now)


class LabelSetDefault(Base):
    """The set of videos that name none: the newest row; without rows ``gtsrb-43``."""

    __tablename__ = "label_set_defaults"

    seq: Mapped[int] = mapped_column(Sequence, primary_key=True, autoincrement=True)
    set_key: Mapped[str] = mapped_column(String(64))
    created: Mapped[datetime] = mapped_column(UtcDateTime, default=now)


class LabelWord(Base):
    """A person's mapping of a name in imported files to a label."""

    __tablename__ = "label_words"

    set_key: Mapped[str] = mapped_column(String(64), primary_key=True)
    word: Mapped[str] = mapped_column(String(200), primary_key=True)
    """Name as in files."""
    label_id: Mapped[int] = mapped_column(Integer)
    """-1: no label of the set."""
    author: Mapped[str] = mapped_column(Text)
    created: Mapped[datetime] = mapped_column(UtcDateTime, default=now)


class LabelPicture(Base):
    """The picture of a label, cut from a track or drawn by the team."""

    __tablename__ = "label_pictures"

    sha256: Mapped[str] = mapped_column(String(64), primary_key=True)
    """SHA-256 of ``png``; labels refer to it as ``sha256:...``."""
    png: Mapped[bytes] = mapped_column(LargeBinary)
    created: Mapped[datetime] = mapped_column(UtcDateTime, default=now)
