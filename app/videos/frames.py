"""Frames for the page: decoded by the engine's reader, encoded and cached; frames near the displayed one in advance."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Container
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeVar

from app.errors import ApiError, Conflict, NotFound
from app.files.shared import ensure_local
from app.settings import Settings
from app.storage.database import Database
from app.storage.lookup import require_video
from app.storage.servers import require_local
from app.videos.checked_file import ChangedError, current_stamp, library_file
from app.videos.decoding import Encoding, Opener, open_in_process
from app.videos.error_text import with_upload_name
from app.videos.file_changes import confirm_content, file_changed_error
from app.videos.frame_server import FrameServer, FrameServerClosedError
from app.videos.import_files import preview_path
from app.videos.packed_table import unpack
from app.videos.picture_cache import PictureCache
from app.videos.previews import Previews
from tsr_engine.errors import TsrError
from tsr_engine.records import Picture

T = TypeVar("T")
_MAX_OPEN = 4


@dataclass(frozen=True, slots=True)
class Served:
    """One encoded picture; ``data`` is None if the page already has it."""

    data: bytes | None
    encoding: Encoding
    ordinal: int
    pts: int
    etag: str
    exact: bool = True
    """False: a small, soft preview for scrubbing; request the picture again later."""


class FrameService:
    """Pictures of imported videos, by ordinal.

    Args:
        settings: with the data folder and the limits of its videos.
        database: with the videos.
        decoder: opens a video's file; unset: in this process.
    """

    def __init__(self, settings: Settings, database: Database, decoder: Opener = open_in_process) -> None:
        self._decoder = decoder
        self._settings = settings
        self._database = database
        self.cache = PictureCache(settings.frame_cache_mb * 2**20)
        self.open_servers: OrderedDict[str, FrameServer] = OrderedDict()
        self._lock = threading.Lock()
        self._loading: dict[str, threading.Lock] = {}

    def picture(
        self,
        video_id: str,
        ordinal: int,
        width: int | None,
        encoding: Encoding,
        etags: Container[str] = (),
        *,
        preview: bool = False,
    ) -> Served:
        """Return frame ``ordinal``, at most ``width`` px wide (rounded up to one of ``WIDTHS``), never enlarged.

        Args:
            video_id: the video.
            ordinal: 0-based, in presentation order.
            width: px; unset: the video's own.
            encoding: ``jpeg`` or ``webp``.
            etags: ETags that the page has; such a picture is not made again.
            preview: allow a small, soft picture if that is faster.

        Raises:
            NotFound: no such video or frame, or its file is missing.
            Conflict: the video is not imported, or its file was replaced.
        """

        def serve(frame_server: FrameServer) -> Served:
            if not 0 <= ordinal < len(frame_server.table):
                raise NotFound(
                    f"The video has frames 0 to {len(frame_server.table) - 1}. Got {ordinal}.", field="ordinal"
                )
            wanted = frame_server.served_width(width)
            etag = f'"{video_id[:20]}-{ordinal}-{wanted}-{encoding}"'
            soft = frame_server.preview(ordinal, wanted, encoding) if preview else None
            if soft is not None:
                return Served(soft, encoding, ordinal, int(frame_server.table.pts[ordinal]), etag, exact=False)
            data = None if etag in etags else frame_server.get(ordinal, wanted, encoding)
            return Served(data, encoding, ordinal, int(frame_server.table.pts[ordinal]), etag)

        return self._with_frame_server(video_id, serve)

    def raw(self, video_id: str, ordinal: int) -> Picture:
        """Return frame ``ordinal`` as the engine reads it, BGR.

        Raises:
            NotFound, Conflict: as for ``picture``.
        """
        return self._with_frame_server(video_id, lambda frame_server: frame_server.read(ordinal))

    def _with_frame_server(self, video_id: str, use: Callable[[FrameServer], T]) -> T:
        for _ in range(8):
            try:
                return use(self._frame_server(video_id))
            except FrameServerClosedError:
                continue  # closed in between to make room for other videos
            except Conflict:
                self.forget(video_id)  # do not reuse a decoder that has failed
                raise
        raise Conflict("Too many videos are open at once. Try again.", code="busy")

    def forget(self, video_id: str) -> None:
        """Close a video's file."""
        with self._lock:
            frame_server = self.open_servers.pop(video_id, None)
        if frame_server is not None:
            frame_server.close()

    def close(self) -> None:
        """Close all files."""
        with self._lock:
            frame_servers, self.open_servers = list(self.open_servers.values()), OrderedDict()
        for frame_server in frame_servers:
            frame_server.close()

    def _frame_server(self, video_id: str) -> FrameServer:
        return self._cached_server(video_id) or self._open_server(video_id)

    def _cached_server(self, video_id: str) -> FrameServer | None:
        with self._lock:
            frame_server = self.open_servers.get(video_id)
            if frame_server is not None:
                self.open_servers.move_to_end(video_id)
        if frame_server is not None and current_stamp(frame_server.path) != frame_server.status:
            self.forget(video_id)
            return None
        return frame_server

    def _open_server(self, video_id: str) -> FrameServer:
        # A page that opens requests several frames at once: they share one decoder.
        with self._lock:
            loading = self._loading.setdefault(video_id, threading.Lock())
        with loading:
            frame_server = self._cached_server(video_id)
            if frame_server is not None:
                return frame_server
            frame_server = self.load(video_id)
            with self._lock:
                self.open_servers[video_id] = frame_server
                dropped = []
                while len(self.open_servers) > _MAX_OPEN:
                    dropped.append(self.open_servers.popitem(last=False)[1])
        for old in dropped:
            old.close()
        return frame_server

    def load(self, video_id: str) -> FrameServer:
        """Open a video of the library; the caller owns the result.

        Raises:
            NotFound: no such video, or its file is missing.
            Conflict: the video is not imported, or its file was replaced or cannot be read.
        """
        with self._database.read() as session:
            row = require_video(session, video_id, table=True)
            require_local(session, row.place, row.name)
        if row.state != "ready" or row.frame_table is None:
            raise Conflict(f"{row.name} is {row.state}, so its frames cannot be shown yet.", code="not_ready")
        path, file = row.path, library_file(self._settings, row)
        if not file.exists:
            remedy = "Upload it again." if row.owned else "Put it back, or add the video from its new path."
            raise NotFound(with_upload_name(row, f"{path} is missing. {remedy}"), code="missing")
        try:
            confirm_content(self._database, file, row)
            table, limits = unpack(row.frame_table), self._settings.video_limits
            video = self._decoder(file, limits, table)
        except ChangedError:
            raise file_changed_error(row) from None
        except TsrError as error:
            raise Conflict(with_upload_name(row, str(error)), code="unreadable") from None
        stamp = file.stamp
        assert stamp is not None
        copy = preview_path(self._settings.home, video_id)
        if not copy.exists():
            with suppress(ApiError):  # not every video has a copy
                ensure_local(self._settings, row.place, str(copy.relative_to(self._settings.home)))
        previews = Previews(copy, len(table), lambda file: self._decoder(file, limits))
        return FrameServer(video_id, video, table, self.cache, stamp, previews)
