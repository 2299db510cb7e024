"""Checks whether a file is still that of a video, and refuses work on another one."""

from __future__ import annotations

import threading
from contextlib import suppress

from sqlalchemy import bindparam, select
from sqlalchemy.exc import DBAPIError

from app.errors import Conflict
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Run, Video
from app.storage.servers import require_local, shared_files_id
from app.videos.checked_file import ChangedError, CheckedFile, current_stamp, library_file
from app.videos.error_text import with_upload_name
from tsr_engine.errors import InputError, VideoError
from tsr_engine.io.opened_file import Stamp

_OF_RUN = select(Video, Run.place, Run.name).join(Run, Run.video_id == Video.id).where(Run.id == bindparam("run"))


def confirm_content(database: Database, file: CheckedFile, video: Video) -> None:
    """Make sure that a file has the video's bytes. They are read once after each change of the file.

    Raises:
        ChangedError: it has other bytes.
        VideoError: it is missing or cannot be read.
    """
    file.open().close()
    if file.stamp is not None and list(file.stamp) != video.stamp:
        with suppress(DBAPIError), database.write() as session:  # otherwise they are read again next time
            row = session.get(Video, video.id)
            if row is not None and row.path == str(file.path):
                row.stamp = list(file.stamp)


def require_unchanged(database: Database, file: CheckedFile, video: Video) -> None:
    """Check for a job that the file exists and has the video's bytes, because its frame table is relied on.

    Raises:
        InputError: it is missing, or has other bytes.
        VideoError: it cannot be read.
    """
    if not file.exists:
        raise InputError(f"{file} is missing. Put it back, or add the video from its new path.")
    try:
        confirm_content(database, file, video)
    except ChangedError:
        raise InputError(f"{file} has changed since it was added. Add it again as another video.") from None


def file_changed_error(video: Video) -> Conflict:
    """Return the refusal of an operation on frames that can no longer be shown."""
    message = f"{video.path} has changed since it was added. Restore it, or add it as another video."
    return Conflict(with_upload_name(video, message), code="file_changed")


class ChangedFiles:
    """Refuses edits of a video while another file has its path.

    A missing or unreadable file blocks nothing: edits apply to frames of the video that its hash identifies, and their
    evidence is stored. So people can work while a disk is not plugged in.
    """

    def __init__(self, settings: Settings, database: Database) -> None:
        self._settings = settings
        self._database = database
        self._lock = threading.Lock()
        self._known: dict[str, tuple[Stamp, bool]] = {}
        """Video -> state of its file when its bytes were last compared, and whether they were the video's."""

    def refuse(self, run_id: str) -> None:
        """Check the file of a run's video; its bytes are read once after each change.

        Raises:
            Conflict: it has other bytes (``file_changed``).
            OnOtherServer: the run lies on another server.
        """
        with self._database.read_once() as session:
            found = session.execute(_OF_RUN, {"run": run_id}).first()
            if found is None:
                return
            require_local(session, found.place, found.name)
            shared = shared_files_id(session)
        video: Video = found.Video
        if video.place is not None and video.place == shared:
            return  # ignore a local file of that name: the video is identified by its bytes
        file = library_file(self._settings, video)
        stamp = current_stamp(file.path)
        if stamp is not None and stamp != file.stamp and not self._is_same(video, file, stamp):
            raise file_changed_error(video)

    def _is_same(self, video: Video, file: CheckedFile, stamp: Stamp) -> bool:
        with self._lock:  # parallel requests for the same file need not read it again
            known = self._known.get(video.id)
            if known is None or known[0] != stamp:
                try:
                    confirm_content(self._database, file, video)
                    known = (stamp, True)
                except ChangedError:
                    known = (stamp, False)
                except VideoError:
                    return True
                self._known[video.id] = known
            return known[1]
