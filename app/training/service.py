"""Operations on model versions: request, promote, roll back, remove."""

from __future__ import annotations

import shutil
import uuid
from datetime import UTC, datetime
from typing import Final

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.errors import Conflict, Invalid, NotFound
from app.events import EventBus
from app.files.shared import ensure_local, remove_shared
from app.jobs.outcome import cancel_subject
from app.jobs.queue import JobQueue
from app.settings import Settings
from app.storage.database import Database
from app.storage.lookup import ACTIVE
from app.storage.models import ModelVersion, Run
from app.storage.servers import require_local
from app.training.folders import RUN_COMPONENTS, SHIPPED_ID, active_version, hashes_of
from app.training.request import NewModel, lineage_of, public_folders
from app.training.sources import TrainingSources, training_sources
from app.training.view import ModelView, label_facts, library_labels, model_view, publish_model
from tsr_engine.errors import ModelError
from tsr_engine.io.models import MANIFEST, SHIPPED, load_component, read_manifest
from tsr_engine.labels.model import LabelSet

JOB: Final = "retrain"


class TrainingService:
    """Trains, lists, promotes, rolls back, cancels and removes versions."""

    def __init__(self, settings: Settings, database: Database, events: EventBus, jobs: JobQueue) -> None:
        self._settings = settings
        self._database = database
        self._events = events
        self._jobs = jobs

    def list(self) -> tuple[list[ModelView], str | None]:
        """All versions, newest first and the shipped one last; and the name of the active one."""
        with self._database.read() as session:
            active = active_version(session)
            active_id = None if active is None else active.id
            rows = session.scalars(select(ModelVersion).order_by(ModelVersion.created.desc(), ModelVersion.id))
            labels = library_labels(session)
            views = [model_view(row, row.id == active_id, labels) for row in rows]
        return [*views, self._shipped(active_id is None, labels)], active_id or SHIPPED_ID

    def sources(self) -> TrainingSources:
        """Data of this data folder that a version can be trained from."""
        with self._database.read() as session:
            return training_sources(session)

    def get(self, version_id: str) -> ModelView:
        """Return one version.

        Raises:
            NotFound: no such version.
        """
        for view in self.list()[0]:
            if view.id == version_id:
                return view
        raise NotFound(f"There are no models {version_id[:40]!r}.")

    def start(self, wanted: NewModel) -> ModelView:
        """Queue the training of a version.

        Raises:
            Invalid: there is nothing to learn from, two runs belong to one video, the parent is unknown, a path is not
                a folder, or the name is that of the shipped models.
            Refused: a folder lies outside the allowed ones.
            NotFound: no such run or export.
            Conflict: a run, an export or the parent is not complete.
        """
        if wanted.name.strip().casefold() == SHIPPED_ID:
            raise Invalid(f"{wanted.name!r} names the models without any training. Choose another name.", field="name")
        folders = public_folders(wanted, self._settings.roots)
        with self._database.write() as session:
            parent = self._parent(session, wanted.parent)
            asked = lineage_of(session, wanted, folders)
            version = ModelVersion(
                id=uuid.uuid4().hex,
                name=wanted.name or self._next_name(session),
                parent_id=None if parent is None else parent.id,
                lineage={"asked": asked},
            )
            version.folder = f"models/{version.id}"
            session.add(version)
            session.flush()
            self._jobs.submit(session, JOB, version.id)
            publish_model(session, self._events, version)
            return model_view(version, False, library_labels(session))

    def promote(self, version_id: str) -> ModelView:
        """Use a version for new runs; ``shipped`` means the models without any training.

        Raises:
            NotFound: no such version.
            Conflict: it is not complete, or its files are damaged.
        """
        with self._database.write() as session:
            previous = active_version(session)
            if version_id == SHIPPED_ID:
                for row in session.scalars(select(ModelVersion).where(ModelVersion.promoted > 0)):
                    row.promoted = 0
                self._publish(session, previous)
                return self._shipped(True, library_labels(session))
            version = _require(session, version_id)
            if version.state != "complete":
                raise Conflict(
                    f"{version.name} is {version.state}. Only a complete version can be used.", code="not_complete"
                )
            require_local(session, version.place, version.name)
            self._require_undamaged(version)
            version.promoted = (session.scalar(select(func.max(ModelVersion.promoted))) or 0) + 1
            self._publish(session, previous)
            publish_model(session, self._events, version)
            return model_view(version, True, library_labels(session))

    def rollback(self) -> ModelView:
        """Revert the last promotion.

        Returns:
            The version that is active now.

        Raises:
            Conflict: nothing was promoted.
        """
        with self._database.write() as session:
            version = active_version(session)
            if version is None:
                raise Conflict(
                    "The shipped models are active, so there is no promotion to roll back.", code="nothing_promoted"
                )
            version.promoted = 0
            self._publish(session, version)
            active = active_version(session)
            self._publish(session, active)
            labels = library_labels(session)
            return self._shipped(True, labels) if active is None else model_view(active, True, labels)

    def cancel(self, version_id: str) -> ModelView:
        """Cancel the training of a version; its entry is kept, so that it can be resumed."""
        with self._database.write() as session:
            version = _require(session, version_id)
            cancel_subject(session, self._jobs, version_id)
            return model_view(version, False, library_labels(session))

    def resume(self, version_id: str) -> ModelView:
        """Train a cancelled or failed version again, with the same request.

        Raises:
            NotFound: no such version.
            Conflict: it is being trained, or complete.
        """
        with self._database.write() as session:
            version = _require(session, version_id)
            if version.state in (*ACTIVE, "complete"):
                raise Conflict(f"{version.name} is {version.state}, so it cannot be resumed.", code="not_resumable")
            version.state, version.error, version.stage, version.done = "queued", None, "", 0
            self._jobs.submit(session, JOB, version.id, place=version.place)
            publish_model(session, self._events, version)
            return model_view(version, False, library_labels(session))

    def remove(self, version_id: str) -> None:
        """Remove a version and its files.

        Raises:
            NotFound: no such version.
            Conflict: it is being trained, active, a parent, or runs were made with it.
        """
        with self._database.write() as session:
            version = _require(session, version_id)
            require_local(session, version.place, version.name)
            if version.state in ACTIVE:
                raise Conflict(f"{version.name} is {version.state}. Cancel it first.", code="still_running")
            if version is active_version(session):
                raise Conflict(f"{version.name} is active. Promote another version, or roll back.", code="in_use")
            user = _user(session, version)
            if user is not None:
                raise Conflict(f"{version.name} is in use by {user}. Remove that first.", code="in_use")
            session.delete(version)
            self._events.publish(session, "removed", version_id, {"model": version_id})
        for suffix in ("", ".part", ".work"):
            shutil.rmtree(self._settings.home / "models" / f"{version_id}{suffix}", ignore_errors=True)
        remove_shared(self._settings, [(version.place, version.folder)])

    # ------------------------------------------------------------------------------------------------------ parts

    def _publish(self, session: Session, version: ModelVersion | None) -> None:
        if version is not None:
            publish_model(session, self._events, version)

    def _parent(self, session: Session, name: str | None) -> ModelVersion | None:
        if name == SHIPPED_ID:
            return None
        parent = active_version(session) if name is None else session.get(ModelVersion, name)
        if name is not None and parent is None:
            raise Invalid(f"There are no models {name[:40]!r} to start from.", field="parent")
        if parent is not None and parent.state != "complete":
            raise Conflict(f"{parent.name} is {parent.state}. Start from a complete version.", code="not_complete")
        if parent is not None:
            require_local(session, parent.place, parent.name)
        return parent

    def _next_name(self, session: Session) -> str:
        used = set(session.scalars(select(ModelVersion.name)))
        return next(name for k in range(1, len(used) + 2) if (name := f"Version {k}") not in used)

    def _require_undamaged(self, version: ModelVersion) -> None:
        """Refuse a version whose files have changed since it was trained."""
        folder = ensure_local(self._settings, version.place, version.folder)
        try:
            found = {name: load_component(name, folder).sha256 for name in version.models}
        except ModelError as error:
            raise Conflict(f"{version.name} is damaged: {error}", code="damaged") from None
        if found != version.models:
            raise Conflict(
                f"{version.name} is damaged: its files have changed since it was trained. Train it again.",
                code="damaged",
            )

    def _shipped(self, active: bool, labels: LabelSet) -> ModelView:
        folder = self._settings.models or SHIPPED
        components = read_manifest(folder)["components"]
        changed = datetime.fromtimestamp((folder / MANIFEST).stat().st_mtime, UTC).isoformat()
        return ModelView(
            id=SHIPPED_ID,
            name="Shipped" if self._settings.models is None else folder.name,
            state="complete",
            error=None,
            parent_id=None,
            lineage={"data": {name: entry.get("data", {}) for name, entry in components.items()}},
            figures={name: entry.get("figures", {}) for name, entry in components.items()},
            models=hashes_of(self._settings.models),
            stage="",
            note="",
            done=0,
            total=None,
            active=active,
            created=changed,
            finished=changed,
            **label_facts(components["classifier"].get("params", {}).get("labels"), labels),
        )


def _require(session: Session, version_id: str) -> ModelVersion:
    version = session.get(ModelVersion, version_id)
    if version is None:
        raise NotFound(f"There are no models {version_id[:40]!r}.")
    return version


def _user(session: Session, version: ModelVersion) -> str | None:
    """What needs a version: another version that starts from it, or a run that was made with it."""
    child = session.scalars(
        select(ModelVersion).where(ModelVersion.parent_id == version.id, ModelVersion.state.in_(ACTIVE)).limit(1)
    ).first()
    if child is not None:
        return child.name
    for run in session.scalars(select(Run)):
        used = {name: digest for name, digest in run.models.items() if name in RUN_COMPONENTS}
        if used and all(version.models.get(name) == digest for name, digest in used.items()):
            return run.name or "a run"
    return None
