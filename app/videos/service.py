"""Operations on videos: add by path or upload, read, remove."""

from __future__ import annotations

import shutil
import stat
from collections.abc import Sequence
from pathlib import Path

from pydantic_core import to_json
from sqlalchemy import select
from sqlalchemy.orm import Session

from app.errors import Conflict, Invalid, NotFound, OnOtherServer, UnsupportedMedia
from app.events import EventBus
from app.files.shared import ensure_local, remove_shared
from app.ground_truths.service import GroundTruthService
from app.jobs.queue import JobQueue
from app.settings import Settings
from app.storage.database import Database
from app.storage.lookup import require_video
from app.storage.models import Job, Run, Video
from app.storage.servers import Servers, require_local, this_server
from app.videos.checked_file import allowed_roots, library_file, trusted_file
from app.videos.import_files import clear_import, import_files, thumbnail_path
from app.videos.packed_table import unpack
from app.videos.paths import open_allowed
from app.videos.uploads import Uploads
from app.videos.view import VideoView, publish_video, video_listing, video_view
from sample_videos import SHIPPED
from tsr_engine.errors import VideoError
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import Stamp, stamp_of
from tsr_engine.io.unfinished import fsync_path
from tsr_engine.io.video_probe import check_file


class VideoService:
    """Videos, identified by their SHA-256."""

    def __init__(
        self,
        settings: Settings,
        database: Database,
        events: EventBus,
        jobs: JobQueue,
        uploads: Uploads,
        servers: Servers | None = None,
    ) -> None:
        self._settings = settings
        self._database = database
        self._events = events
        self._jobs = jobs
        self._uploads = uploads
        self._servers = servers

    def listing(self) -> bytes:
        """All videos, newest first, as the JSON response ``{"videos": [VideoView, ...]}``."""
        with self._database.read() as session:
            return to_json({"videos": video_listing(session)})

    def view(self, video_id: str) -> VideoView:
        """Return one video.

        Raises:
            NotFound: no such video.
        """
        with self._database.read() as session:
            return video_view(session, require_video(session, video_id))

    def thumbnail(self, video_id: str) -> Path:
        """Return the path of a video's thumbnail; it need not exist.

        Raises:
            OnOtherServer: it lies on another server.
            Busy: it is still being fetched from the shared files.
        """
        path = thumbnail_path(self._settings.home, video_id)
        with self._database.read() as session:
            video = session.get(Video, video_id)
            if video is None:
                return path
            require_local(session, video.place, video.name)
        return ensure_local(self._settings, video.place, str(path.relative_to(self._settings.home)))

    def _take_over(self, session: Session, video: Video) -> bool:
        """Take over a video whose server is gone; False if it already belongs to this server.

        Raises:
            OnOtherServer: that server is alive.
        """
        self._refuse_elsewhere(session, video)
        server = this_server(session)
        if server is None or video.place == server:
            return False
        video.place = server
        return True

    def _refuse_elsewhere(self, session: Session, video: Video) -> None:
        if self._servers is None or not self._servers.is_dead(video.place):
            require_local(session, video.place, video.name)

    def table(self, video_id: str) -> FrameTable:
        """Return the frame table of an imported video.

        Raises:
            NotFound: no such video.
            Conflict: it is not imported yet.
        """
        with self._database.read() as session:
            video = require_video(session, video_id, table=True)
            if video.frame_table is None:
                raise Conflict(f"{video.name} is {video.state}: its frames are not known yet.", code="not_ready")
            return unpack(video.frame_table)

    def add_samples(self, ground_truths: GroundTruthService) -> None:
        """Add the bundled drives with their exact ground truth to the library; existing ones stay as they are."""
        for clip in reversed(SHIPPED):
            with trusted_file(clip.video).open() as file:
                place, stamp, digest = clip.video.resolve(), file.stamp, file.sha256()
            with self._database.read() as session:
                known = session.get(Video, digest)
            if known is not None and (known.path == str(place) or known.place == self._database.shared is not None):
                continue
            try:
                self.add_row(digest, clip.video.name, place, stamp, owned=False, sample=True)
            except OnOtherServer:
                continue  # another server of the database has it
            if known is None:
                ground_truths.put(digest, "exact truth", clip.truth.read_bytes())

    def sample(self) -> tuple[str, str | None] | None:
        """Return video and newest run of the first bundled drive, if it is in the library."""
        with self._database.read() as session:
            for clip in SHIPPED:
                video = session.scalars(select(Video).where(Video.sample, Video.name == clip.video.name)).first()
                if video is not None:
                    newest = select(Run.id).where(Run.video_id == video.id, Run.kind == "engine")
                    return video.id, session.scalars(newest.order_by(Run.order.desc()).limit(1)).first()
        return None

    def add_path(self, text: str) -> VideoView:
        """Add a file of this machine; known content is the same video, and gets the new path.

        Raises:
            Invalid: the path is invalid, a folder, or not a video by its first bytes.
            Refused: it is outside the allowed folders.
            NotFound: no such file.
        """
        with open_allowed(text, allowed_roots(self._settings)) as file:
            path = file.path
            if stat.S_ISDIR(file.status.st_mode):
                raise Invalid(f"{path} is a folder. Name a video in it.", field="path", code="a_folder")
            if not stat.S_ISREG(file.status.st_mode):
                raise NotFound(f"There is no file {path}.", field="path")
            try:
                check_file(file)
                stamp, digest = file.stamp, file.sha256()
            except VideoError as error:
                raise Invalid(str(error), field="path", code="not_a_video") from None
            with self._uploads.lock(digest):
                if not path.is_file():  # it was an upload that has just been removed
                    raise NotFound(f"There is no file {path} any more.", field="path")
                return self.add_row(digest, path.name, path, stamp, owned=False)

    def add_upload(self, part: Path, name: str, digest: str) -> VideoView:
        """Add a finished upload; its temporary file is moved or removed.

        Args:
            part: the received bytes, in the data folder.
            name: file name of the client.
            digest: SHA-256 of the bytes.

        Raises:
            UnsupportedMedia: it is not a video by its first bytes.
            OnOtherServer: the same video lies on another server.
        """
        try:
            with trusted_file(part).open() as file:
                check_file(file)
        except VideoError as error:
            part.unlink(missing_ok=True)
            raise UnsupportedMedia(str(error).replace(str(part), name)) from None
        with self._uploads.lock(digest):
            with self._database.read() as session:
                known = session.get(Video, digest)
                if known is not None:
                    self._refuse_elsewhere(session, known)
            # store it in the shared files again: the old copy may be damaged
            shared = self._database.shared
            local_video = None if known is not None and shared is not None and known.place == shared else known
            if local_video is not None and (stamp := self._valid_stamp(local_video)) is not None:
                part.unlink(missing_ok=True)  # it is already here: one copy is enough
                return self.add_row(digest, local_video.name, Path(local_video.path), stamp, owned=local_video.owned)
            path = self._uploads.path_of(digest, Path(name).suffix.lower()[:8])
            part.replace(path)
            fsync_path(path.parent)
            try:
                view = self.add_row(digest, name, path, stamp_of(path.stat()), owned=True, replaces=True)
            except BaseException:
                self._uploads.remove(path)
                raise
            if known is not None and known.owned:
                self._uploads.remove(Path(known.path))  # a file with another extension that has other bytes now
            return view

    def _valid_stamp(self, video: Video) -> Stamp | None:
        """State of a video's file; None: it does not have the video's bytes."""
        file = library_file(self._settings, video)
        try:
            file.open().close()
        except VideoError:
            return None
        return file.stamp

    def add_row(
        self,
        digest: str,
        name: str,
        path: Path,
        stamp: Stamp,
        *,
        owned: bool,
        sample: bool = False,
        replaces: bool = False,
    ) -> VideoView:
        """Add or update the row of a file; ``replaces``: it replaces the file in the row, which has other bytes."""
        with self._database.write() as session:
            video = session.get(Video, digest)
            if video is None:
                video = Video(id=digest, name=name, path=str(path), size=stamp[1], owned=owned, sample=sample)
                session.add(video)
                session.flush()
                self._jobs.submit(session, "import", digest, priority=10)
            else:
                if self._take_over(session, video) or replaces or not Path(video.path).is_file() or not video.owned:
                    video.path, video.owned, video.stamp = str(path), owned, list(stamp)
                if video.state == "failed":
                    video.state, video.error = "importing", None
                    self._jobs.submit(session, "import", digest, priority=10)
            publish_video(session, self._events, video)
            return video_view(session, video)

    def remove(self, video_id: str) -> Sequence[str]:
        """Remove a video, its runs and its edits; of files only uploads and those of the engine.

        Returns:
            The ids of its runs.

        Raises:
            Conflict: a run or the import is still in progress.
        """
        with self._uploads.lock(video_id):
            return self._remove(video_id)

    def _remove(self, video_id: str) -> Sequence[str]:
        with self._database.write() as session:
            video = require_video(session, video_id)
            self._refuse_elsewhere(session, video)
            runs = list(session.scalars(select(Run).where(Run.video_id == video_id)))
            subjects = [video_id, *(run.id for run in runs)]
            active = select(Job.id).where(Job.subject.in_(subjects), Job.state == "running").limit(1)
            if session.scalars(active).first() is not None:
                raise Conflict(f"The engine is working on {video.name}. Cancel that first.", code="still_running")
            for subject in subjects:
                self._jobs.cancel(session, subject)
            for run in sorted(runs, key=lambda r: r.parent_id is None):
                session.delete(run)
                session.flush()
            session.delete(video)
            self._events.publish(session, "removed", video_id, {"video": video_id})
            path, owned = Path(video.path), video.owned
        home = self._settings.home
        if owned:
            self._uploads.remove(path)
        clear_import(home, video_id)
        evidence = [run for run in runs if run.folder.startswith("runs/") and ".." not in run.folder]
        for run in evidence:
            shutil.rmtree(home / run.folder, ignore_errors=True)
        names = f"videos/{video_id}", *(str(path.relative_to(home)) for path in import_files(home, video_id))
        of_runs = [(run.place, run.folder) for run in evidence]
        remove_shared(self._settings, [*((video.place, name) for name in names), *of_runs])
        return [run.id for run in runs]
