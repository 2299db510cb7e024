"""What people do with videos: add by path or upload, look at, remove."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session, undefer

from app.errors import Conflict, Invalid, NotFound, UnsupportedMedia
from app.events import EventBus
from app.jobs.queue import JobQueue
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Job, Run, Video
from app.videos.glance import glance_path
from app.videos.paths import allowed_path
from app.videos.samples import SampleDrives
from app.videos.table import restamp, unpack
from app.videos.uploads import Uploads
from app.videos.view import VideoView, publish_video, video_view, video_views
from tsr_engine.errors import VideoError
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.unfinished import fsync_path
from tsr_engine.io.video_probe import check_file, video_sha256

__all__ = ["VideoService"]


class VideoService(SampleDrives):
    """Videos by their SHA-256."""

    def __init__(
        self, settings: Settings, database: Database, events: EventBus, jobs: JobQueue, uploads: Uploads
    ) -> None:
        self._settings = settings
        self._database = database
        self._events = events
        self._jobs = jobs
        self._uploads = uploads

    def views(self) -> list[VideoView]:
        """All videos, the newest first."""
        with self._database.read() as session:
            videos = session.scalars(select(Video).order_by(Video.created.desc(), Video.name)).all()
            return video_views(session, videos)

    def view(self, video_id: str) -> VideoView:
        """One video.

        Raises:
            NotFound: there is none of that name.
        """
        with self._database.read() as session:
            return video_view(session, self.get(session, video_id))

    def get(self, session: Session, video_id: str) -> Video:
        """One row.

        Raises:
            NotFound: there is none of that name.
        """
        video = session.get(Video, video_id)
        if video is None:
            raise NotFound(f"There is no video {video_id[:80]!r}.")
        return video

    def table(self, video_id: str) -> FrameTable:
        """The frame table of an imported video.

        Raises:
            NotFound: no such video.
            Conflict: it is not imported (yet).
        """
        with self._database.read() as session:
            query = select(Video).where(Video.id == video_id).options(undefer(Video.frame_table))
            video = session.scalars(query).first()
            if video is None:
                raise NotFound(f"There is no video {video_id[:80]!r}.")
            if video.frame_table is None:
                raise Conflict(f"{video.name} is {video.state}: its frames are not known yet.", code="not_ready")
            return unpack(video.frame_table)

    def add_path(self, text: str) -> VideoView:
        """Add a file of this machine; the same content added before is the same video, wherever it lies now.

        Raises:
            Invalid: no path, a folder, or no video by its first bytes.
            Refused: outside the allowed folders.
            NotFound: there is no such file.
        """
        path = allowed_path(text, self.readable_roots())
        if path.is_dir():
            raise Invalid(f"{path} is a folder. Name a video in it.", field="path", code="a_folder")
        if not path.is_file():
            raise NotFound(f"There is no file {path}.", field="path")
        try:
            check_file(path)
            digest = video_sha256(path)
        except VideoError as error:
            raise Invalid(str(error), field="path", code="not_a_video") from None
        with self._uploads.turn(digest):
            if not path.is_file():  # it was an upload that somebody has just removed
                raise NotFound(f"There is no file {path} any more.", field="path")
            return self._add(digest, path.name, path, owned=False)

    def add_upload(self, part: Path, name: str, digest: str) -> VideoView:
        """Take a finished upload over; the part file is renamed or removed.

        Args:
            part: the received bytes, in the data folder.
            name: what the person calls it.
            digest: SHA-256 of the bytes.

        Raises:
            UnsupportedMedia: not a video by its first bytes.
        """
        try:
            check_file(part)
        except VideoError as error:
            part.unlink(missing_ok=True)
            raise UnsupportedMedia(str(error).replace(str(part), name)) from None
        with self._uploads.turn(digest):
            with self._database.read() as session:
                known = session.get(Video, digest)
            if known is not None and self._holds(Path(known.path), digest):
                part.unlink(missing_ok=True)  # it lies here already: one copy is enough
                return self._add(digest, known.name, Path(known.path), owned=known.owned)
            place = self._uploads.place(digest, Path(name).suffix.lower()[:8])
            part.replace(place)
            fsync_path(place.parent)
            try:
                view = self._add(digest, name, place, owned=True, anew=True)
            except BaseException:
                self._uploads.remove(place)
                raise
            if known is not None and known.owned:
                self._uploads.remove(Path(known.path))  # it held other bytes by now, under another ending
            return view

    @staticmethod
    def _holds(path: Path, digest: str) -> bool:
        try:
            return video_sha256(path) == digest
        except VideoError:
            return False

    def _add(
        self, digest: str, name: str, path: Path, *, owned: bool, sample: bool = False, anew: bool = False
    ) -> VideoView:
        """A row for a file; ``anew``: it takes the place of the one that the row names, which is not the video's."""
        with self._database.write() as session:
            video = session.get(Video, digest)
            if video is None:
                video = Video(id=digest, name=name, path=str(path), size=path.stat().st_size, state="importing")
                video.owned, video.sample = owned, sample
                session.add(video)
                session.flush()
                self._jobs.submit(session, "import", digest, priority=10)
            else:
                if anew or not Path(video.path).is_file() or not video.owned:
                    video.path, video.owned = str(path), owned
                    if video.frame_table is not None:
                        video.frame_table = restamp(video.frame_table, path)
                if video.state == "failed":
                    video.state, video.error = "importing", None
                    self._jobs.submit(session, "import", digest, priority=10)
            publish_video(session, self._events, video)
            return video_view(session, video)

    def remove(self, video_id: str) -> Sequence[str]:
        """Remove a video, its runs and its edits; of files only uploads and what the engine wrote.

        Returns:
            The names of its runs.

        Raises:
            Conflict: a run or the import is still going on.
        """
        with self._uploads.turn(video_id):
            return self._remove(video_id)

    def _remove(self, video_id: str) -> Sequence[str]:
        with self._database.write() as session:
            video = self.get(session, video_id)
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
        (home / "thumbnails" / f"{video_id}.jpg").unlink(missing_ok=True)
        glance_path(home, video_id).unlink(missing_ok=True)
        self.remove_folders([run.folder for run in runs])
        return [run.id for run in runs]
