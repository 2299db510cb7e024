"""Tables of label sets; part of ``app.storage.models``."""

from __future__ import annotations

from datetime import datetime

from sqlalchemy import BigInteger, Integer, LargeBinary, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from app.storage.base import Base, Sequence, now
from app.storage.moments import Moment

__all__ = ["LabelPicture", "LabelSetDefault", "LabelSetVersion", "LabelWord"]


class LabelSetVersion(Base):
    """One version of a label set; immutable. A set that ships with the package has rows from its first change on."""

    __tablename__ = "label_sets"

    key: Mapped[str] = mapped_column(String(64), primary_key=True)
    version: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=False)
    author: Mapped[str] = mapped_column(Text)
    """Empty: it came with the package or a file, as it is."""
    sentence: Mapped[str] = mapped_column(Text)
    """What the change did."""
    undoes: Mapped[int | None]
    """The version whose change it took back."""
    next_id: Mapped[int] = mapped_column(BigInteger)
    """The first id that is not given out yet: tells which version added a label."""
    document: Mapped[bytes] = mapped_column(LargeBinary, deferred=True)
    """The set in our file format, deflated."""
    created: Mapped[datetime] = mapped_column(Moment, default=now)


class LabelSetDefault(Base):
    """Which set videos use that name none: the newest row; none: ``gtsrb-43``."""

    __tablename__ = "label_set_defaults"

    seq: Mapped[int] = mapped_column(Sequence, primary_key=True, autoincrement=True)
    set_key: Mapped[str] = mapped_column(String(64))
    created: Mapped[datetime] = mapped_column(Moment, default=now)


class LabelWord(Base):
    """What a name in imported files stands for, as a person said."""

    __tablename__ = "label_words"

    set_key: Mapped[str] = mapped_column(String(64), primary_key=True)
    word: Mapped[str] = mapped_column(String(200), primary_key=True)
    """As it stands in files."""
    label_id: Mapped[int] = mapped_column(Integer)
    """-1: no label of the set."""
    author: Mapped[str] = mapped_column(Text)
    created: Mapped[datetime] = mapped_column(Moment, default=now)


class LabelPicture(Base):
    """The picture of a label, cut from a track or drawn by the team."""

    __tablename__ = "label_pictures"

    sha256: Mapped[str] = mapped_column(String(64), primary_key=True)
    """Of ``png``; labels name it ``sha256:...``."""
    png: Mapped[bytes] = mapped_column(LargeBinary)
    created: Mapped[datetime] = mapped_column(Moment, default=now)
