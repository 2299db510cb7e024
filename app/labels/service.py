"""Operations on label sets: read, change, undo, and choose the set in use."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NoReturn, TypeVar

from sqlalchemy import ColumnElement, or_, select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from app.errors import Busy, Conflict, Invalid, NotFound
from app.events import EventBus
from app.labels import commands
from app.labels.pictures import picture_exists, store_picture
from app.labels.references import is_imported, referenced_ids, videos_using
from app.labels.store import added_by, append, at_version, default_key, history, labels_of_video, newest, set_keys
from app.labels.views import Change, LabelSetView, LabelVersion, LabelView, label_view
from app.storage.database import Database
from app.storage.models import LabelSetDefault, LabelSetVersion, Video
from app.videos.view import publish_video
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels import changes
from tsr_engine.labels.adopting import adopt_labels
from tsr_engine.labels.conflicts import ChangeError, NoLabelError, TakenError
from tsr_engine.labels.files import SHIPPED
from tsr_engine.labels.model import Label, LabelSet
from tsr_engine.labels.undo import undo_change

_MAX_ATTEMPTS = 50
"""Attempts to change a set while others change it too."""

Make = Callable[[Session, LabelSet], changes.Changed]
Stored = TypeVar("Stored")


class LabelService:
    """The label sets of a library."""

    def __init__(self, database: Database, events: EventBus) -> None:
        self._database = database
        self._events = events

    def labels(self, video_id: str | None = None) -> list[LabelView]:
        """Labels of a video's set in the order of the set; without a video, of the library's default.

        Raises:
            NotFound: no such video.
        """
        return self.views(self.of_video(video_id) if video_id is not None else self.get(None))

    @staticmethod
    def views(labels: LabelSet, chosen: Iterable[Label] | None = None) -> list[LabelView]:
        """Convert labels of a set to views; ``chosen`` None: all."""
        return [label_view(labels, label) for label in (labels if chosen is None else chosen)]

    def of_video(self, video_id: str) -> LabelSet:
        """The newest version of a video's set.

        Raises:
            NotFound: there is no such video.
        """
        with self._database.read() as session:
            return labels_of_video(session, video_id)

    def get(self, key: str | None, version: int | None = None) -> LabelSet:
        """Return a set.

        Args:
            key: its key; None: the library's default.
            version: its version; None: the newest.

        Raises:
            NotFound: no such set or version.
        """
        with self._database.read() as session:
            key = default_key(session) if key is None else key
            return newest(session, key) if version is None else at_version(session, key, version)

    def label(self, key: str | None, label_id: int) -> Label:
        """Return one label of a set; ``key`` None: of the library's default.

        Raises:
            NotFound: no such set or label.
        """
        labels = self.get(key)
        found = labels.get(label_id)
        if found is None:
            raise NotFound(f"The label set {labels.key!r} has no label {label_id}.")
        return found

    def video_named(self, text: str) -> str:
        """Find the id of the video with a name, a path or an id.

        Raises:
            NotFound: there is none, or there are several.
        """
        named = or_(Video.id == text, Video.name == text, Video.path == str(Path(text).absolute()))
        with self._database.read() as session:
            found = session.scalars(select(Video.id).where(named)).all()
        if len(found) != 1:
            many = "several videos are" if found else "no video is"
            raise NotFound(f"Expected the name, path or id of one video: {many} called {text[:200]!r}.")
        return found[0]

    def sets(self) -> list[LabelSetView]:
        """All sets: those that ship with the package, then the library's own."""
        with self._database.read() as session:
            default = default_key(session)
            return [_set_view(newest(session, key), default) for key in set_keys(session)]

    def history(self, key: str) -> list[LabelVersion]:
        """Versions of a set, the newest first.

        Raises:
            NotFound: there is no such set.
        """
        with self._database.read() as session:
            return [LabelVersion.from_row(row) for row in history(session, key)]

    def change(self, key: str, author: str, change: commands.LabelChange) -> Change:
        """Apply a change to the newest version; a change without effect makes no version.

        Args:
            key: key of the set.
            author: author of the change.
            change: see ``app.labels.commands``.

        Raises:
            NotFound: no such set, label or version.
            Conflict: another label has the word (code ``taken``; ``details`` holds that label and who added it), or a
                later version has changed what is to be undone.
            Invalid: the change breaks a rule of label sets.
        """
        undoes = change.version if isinstance(change, commands.UndoChange) else None
        labels, changed = self.write(
            key, author, lambda session, labels: _apply_change(session, labels, change), undoes
        )
        shown = None if changed.label is None else label_view(labels, changed.label)
        return Change(version=labels.version, label=shown, sentence=changed.sentence)

    def write(self, key: str, author: str, make: Make, undoes: int | None = None) -> tuple[LabelSet, changes.Changed]:
        """Store the result of ``make`` for the newest version; ``make`` is called again if another person was faster.

        Raises:
            NotFound: no such set.
            ApiError: ``make`` raised it.
            Busy: other people keep changing the set.
        """

        def store(session: Session) -> changes.Changed:
            labels = newest(session, key)
            try:
                changed = make(session, labels)
            except ChangeError as error:
                _refuse(session, labels, error)
            if changed.labels is not labels:
                append(session, labels, changed, author, undoes)
                self._events.publish(session, "labels", key, {"version": changed.labels.version})
            return changed

        changed = self._repeat(store, f"changing the label set {key!r}")
        return changed.labels, changed

    def create(self, key: str, make: Callable[[Session], LabelSet | None]) -> LabelSet | None:
        """Store the first version of a set; ``make`` is called again if another person was faster.

        Args:
            key: key of the set.
            make: stores the version and returns it; None: the set already exists.

        Raises:
            Busy: other people keep making a set with that key.
        """

        def store(session: Session) -> LabelSet | None:
            made = make(session)
            session.flush()
            if made is not None:
                self._events.publish(session, "labels", key, {"version": made.version})
            return made

        return self._repeat(store, f"making the label set {key!r}")

    def _repeat(self, store: Callable[[Session], Stored], what: str) -> Stored:
        """Call ``store`` in a transaction, again if another person was faster."""
        for _ in range(_MAX_ATTEMPTS):
            try:
                with self._database.write() as session:
                    return store(session)
            except IntegrityError:
                continue
        raise Busy(f"Too many people are {what}. Repeat the request later.")

    def use_as_default(self, key: str) -> LabelSetView:
        """Use this set for videos that name none.

        Raises:
            NotFound: no such set.
            Conflict: labels that these videos use have another meaning in it.
        """
        with self._database.write() as session:
            present, wanted = default_key(session), newest(session, key)
            if key != present:
                self._require_same_meaning(session, newest(session, present), wanted, Video.label_set.is_(None))
                session.add(LabelSetDefault(set_key=key))
                self._events.publish(session, "labels", key, {"version": wanted.version})
            return _set_view(wanted, key)

    def use_in_video(self, video_id: str, key: str | None) -> LabelSetView:
        """Choose the set of a video; None: the library's default.

        Raises:
            NotFound: no such video or set.
            Conflict: labels that the video uses have another meaning in it.
        """
        with self._database.write() as session:
            present = labels_of_video(session, video_id)
            default = default_key(session)
            wanted = newest(session, key or default)
            if wanted.key != present.key:
                self._require_same_meaning(session, present, wanted, Video.id == video_id)
            video = session.get(Video, video_id)
            assert video is not None
            if video.label_set != key:
                video.label_set = key
                publish_video(session, self._events, video)
                self._events.publish(session, "labels", wanted.key, {"version": wanted.version})
            return _set_view(wanted, default)

    def _require_same_meaning(
        self, session: Session, present: LabelSet, wanted: LabelSet, videos: ColumnElement[bool]
    ) -> None:
        """Refuse a set in which label ids of stored data have another meaning."""
        present_labels, wanted_labels = ({label.id: label for label in labels} for labels in (present, wanted))
        for number in sorted(referenced_ids(session, videos)):
            present_label, wanted_label = present_labels.get(number), wanted_labels.get(number)
            if present_label is not None and (
                wanted_label is None or wanted_label.key.casefold() != present_label.key.casefold()
            ):
                replacement = "missing" if wanted_label is None else f"'{wanted_label.name}'"
                raise Conflict(
                    f"Edits or ground truths use label {number}, '{present_label.name}', which is {replacement} in "
                    f"'{wanted.name}'. Bring the labels of '{wanted.name}' into '{present.name}' instead.",
                    field="set",
                    code="labels_in_use",
                )


def _set_view(labels: LabelSet, default: str) -> LabelSetView:
    is_default, shipped = labels.key == default, labels.key in SHIPPED
    return LabelSetView.from_row(labels, labels=len(labels), default=is_default, shipped=shipped)


def _apply_change(session: Session, labels: LabelSet, change: commands.LabelChange) -> changes.Changed:
    """The next version, after a change."""
    if isinstance(change, commands.AddLabel):
        if not picture_exists(session, change.pictogram):
            raise Invalid(f"There is no picture {change.pictogram!r}.", field="pictogram")
        return changes.add_label(labels, change.facts())
    if isinstance(change, commands.MergeLabels):
        return changes.merge_labels(labels, change.id, change.into)
    if isinstance(change, commands.HideLabel):
        return changes.hide_label(labels, change.id)
    if isinstance(change, commands.ShowLabel):
        return changes.show_label(labels, change.id)
    if isinstance(change, commands.SetPicture):
        return changes.set_picture(labels, change.id, "" if change.png is None else store_picture(session, change.png))
    if isinstance(change, commands.UndoChange):
        return _undo_change(session, labels, change.version)
    if isinstance(change, commands.AdoptSet):
        return adopt_labels(labels, newest(session, change.set)).changed
    return changes.update_label(labels, change.id, change.facts())


def _undo_change(session: Session, labels: LabelSet, version: int) -> changes.Changed:
    after = at_version(session, labels.key, version)
    if version == 1:
        raise Invalid("Version 1 is the first version of the set, so there is no change to undo.", field="version")
    before = at_version(session, labels.key, version - 1)
    row = session.get(LabelSetVersion, (labels.key, version))
    assert row is not None
    referenced: set[int] | None = None
    imported = is_imported(session, labels.key)

    def used(label_id: int) -> bool:
        nonlocal referenced
        if referenced is None:
            referenced = referenced_ids(session, videos_using(session, labels.key))
        return imported or label_id in referenced

    return undo_change(labels, before, after, row.sentence, used)


def _refuse(session: Session, labels: LabelSet, error: ChangeError) -> NoReturn:
    """Raise the refusal as an API error; if another label has the word, it says who added that label."""
    if isinstance(error, NoLabelError):
        raise NotFound(str(error), field=error.field) from None
    if not isinstance(error, TakenError):
        raise Invalid(str(error), field=error.field) from None
    by = added_by(session, labels.key, error.label.id)
    reported = "" if by is None or not by[0] else f" It was added by {by[0]}."
    details: JsonObject = {
        "label": label_view(labels, error.label).model_dump(mode="json"),
        "by": None if by is None else {"author": by[0], "time": by[1].isoformat()},
    }
    raise Conflict(f"{error}{reported}", code="taken", field=error.field, details=details) from None
