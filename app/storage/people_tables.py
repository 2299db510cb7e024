"""Tables of people: accounts, their secrets, assignments, second opinions; part of ``app.storage.models``."""

from __future__ import annotations

from datetime import datetime

from sqlalchemy import ForeignKey, Integer, String, Text, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from app.storage.base import Base, Sequence, now
from app.storage.utc_times import UtcDateTime


class Person(Base):
    """An account. A library without accounts has one user, who does not sign in."""

    __tablename__ = "people"

    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    name: Mapped[str] = mapped_column(String(80))
    """Author name of the person's changes."""
    key: Mapped[str] = mapped_column(String(255), unique=True)
    """The name with normalised case and Unicode form."""
    role: Mapped[str] = mapped_column(String(16))
    """``admin``, ``reviewer``, ``annotator`` or ``viewer``."""
    created: Mapped[datetime] = mapped_column(UtcDateTime, default=now)


class PersonSecret(Base):
    """A token, or a session of a browser. Only the hash of the secret is stored."""

    __tablename__ = "person_secrets"

    hash: Mapped[str] = mapped_column(String(64), primary_key=True)
    """SHA-256 of the secret."""
    person_id: Mapped[str] = mapped_column(ForeignKey("people.id", ondelete="CASCADE"), index=True)
    kind: Mapped[str] = mapped_column(String(16))
    """``token`` or ``session``."""
    note: Mapped[str] = mapped_column(Text, default="")
    """Purpose of the token."""
    created: Mapped[datetime] = mapped_column(UtcDateTime, default=now)
    revoked: Mapped[datetime | None] = mapped_column(UtcDateTime)


class Assignment(Base):
    """A video, or some frames of it, that a person is to work on."""

    __tablename__ = "assignments"
    __table_args__ = ({"sqlite_autoincrement": True},)  # an outdated page must not change a later assignment

    id: Mapped[int] = mapped_column(Sequence, primary_key=True, autoincrement=True)
    video_id: Mapped[str] = mapped_column(ForeignKey("videos.id", ondelete="CASCADE"), index=True)
    person_id: Mapped[str] = mapped_column(ForeignKey("people.id", ondelete="CASCADE"), index=True)
    first: Mapped[int] = mapped_column(Integer, default=0)
    """First frame."""
    stop: Mapped[int | None]
    """Frame after the last; NULL: to the end."""
    state: Mapped[str] = mapped_column(String(16), default="assigned")
    """``assigned``, ``in_review``, ``returned`` or ``done``."""
    comment: Mapped[str] = mapped_column(Text, default="")
    """Comment of the person who assigned or returned it."""
    changed_by: Mapped[str] = mapped_column(Text)
    """Name of the person who changed it last."""
    revision: Mapped[int] = mapped_column(Integer, default=1)
    """Rises with every change; a change must name the revision that it is based on."""
    created: Mapped[datetime] = mapped_column(UtcDateTime, default=now)
    changed: Mapped[datetime] = mapped_column(UtcDateTime, default=now)


class SecondOpinion(Base):
    """An accepted track that another person looks at without seeing the first answer."""

    __tablename__ = "second_opinions"
    __table_args__ = (
        UniqueConstraint("run_id", "key", name="second_opinion_of_track"),
        {"sqlite_autoincrement": True},  # an answer must not count for a later second opinion
    )

    id: Mapped[int] = mapped_column(Sequence, primary_key=True, autoincrement=True)
    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"))
    key: Mapped[str] = mapped_column(String(64))
    set_key: Mapped[str] = mapped_column(String(64))
    """Label set of the answers."""
    first: Mapped[str] = mapped_column(Text)
    """Name of the person who had last edited the track when it was assigned."""
    first_label: Mapped[int]
    """Its label at that time; -1: none of the set."""
    revision: Mapped[int] = mapped_column(Integer)
    """Revision of the track at that time."""
    person_id: Mapped[str | None] = mapped_column(ForeignKey("people.id", ondelete="SET NULL"), index=True)
    second: Mapped[str] = mapped_column(Text)
    """Name of the second person."""
    second_label: Mapped[int | None]
    """The answer: a label, -1: none of the set; NULL: no sign, or not answered."""
    answered: Mapped[datetime | None] = mapped_column(UtcDateTime)
