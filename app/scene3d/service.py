"""Open 3-D views: started when a page connects, stopped when the last page has left."""

from __future__ import annotations

import gc
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING
from weakref import WeakSet, WeakValueDictionary

import cv2
import numpy as np

from app.edits.log_store import documents_of
from app.errors import ApiError, Busy
from app.events import EventBus
from app.evidence.service import EvidenceService
from app.labels.pictures import Pictograms
from app.scene3d.data import DetectionPoints, Scene3dData, load_detections, load_scene3d
from app.scene3d.prior import Prior
from app.scene3d.scenes.base import Image, SceneContext
from app.scene3d.view import LONG_RUN_S, MANY_TRACKS, View
from app.scene3d.view_state import ViewState
from app.storage.database import Database
from app.storage.models import Run
from app.videos.frames import FrameService
from tsr_engine.errors import TsrError
from tsr_engine.json_shapes import JsonObject
from tsr_engine.records import Picture

if TYPE_CHECKING:
    import viser

MAX_VIEWS = 4
IDLE_TIMEOUT_S = 45.0
"""Seconds that a view lives on without viewers."""
_CHECK_INTERVAL_S = 1.0
_MAX_STORED_STATES = 64
_COLLECT_FOR_S = 10.0
"""Seconds after the end of a view in which its threads end, and its memory is looked for."""
PICTURE_WIDTH = 960


class Scene3dService:
    """Open views by run and name, where the page chooses the name; thread-safe.

    Args:
        database, events, evidence, frames: of the server.
        prior: returns the spatial prior of a run; None: there is none.
    """

    def __init__(
        self,
        database: Database,
        events: EventBus,
        evidence: EvidenceService,
        frames: FrameService,
        prior: Callable[[str], Prior | None],
    ) -> None:
        self._database, self._events = database, events
        self._evidence, self._frames, self._prior = evidence, frames, prior
        self._pictograms = Pictograms(database)
        self.idle = IDLE_TIMEOUT_S
        self._lock = threading.Lock()
        self._views: dict[tuple[str, str], View] = {}
        self._reserved: set[tuple[str, str]] = set()
        """Views that are being made."""
        self._opening: WeakValueDictionary[tuple[str, str], threading.Lock] = WeakValueDictionary()
        self._view_states: OrderedDict[tuple[str, str], JsonObject] = OrderedDict()
        self._stopped: WeakSet[View] = WeakSet()
        self._collect_until = 0.0
        self._ended = threading.Event()
        self._reaper: threading.Thread | None = None

    def check(self, run_id: str) -> None:
        """Refuse a run without results.

        Raises:
            NotFound: no such run.
            Conflict: it has no results yet.
        """
        with self._evidence.reading(self._evidence.stored_run(run_id)):
            pass

    def connect(self, run_id: str, name: str) -> View:
        """Return the view with a name, made if needed, and count one more viewer; call :meth:`disconnect` afterwards.

        Raises:
            NotFound, Conflict: as for :meth:`check`.
            Busy: too many views are open, or the server is ending.
        """
        key = run_id, name
        with self._lock:
            opening = self._opening.setdefault(key, threading.Lock())
        with opening:
            with self._lock:
                view = self._views.get(key)
                if view is not None:
                    view.clients += 1
                    return view
            with self._room(key):
                view = self._open(run_id, name)
                if not self._register(key, view):
                    view.stop()
                    raise Busy("The server is ending. Start it again and reload the page.")
            return view

    def disconnect(self, view: View) -> None:
        """Count one viewer less."""
        with self._lock:
            view.clients -= 1
            view.left_at = time.monotonic()

    def move(self, run_id: str, name: str | None, **changes: object) -> int:
        """Move one or all views of a run; return the number of open ones. The newest state wins."""
        with self._lock:
            views = [
                view for (run, view_name), view in self._views.items() if run == run_id and name in (None, view_name)
            ]
            if name is not None:
                known = self._view_states.pop((run_id, name), {})
                self._view_states[run_id, name] = {**known, **changes}
                while len(self._view_states) > _MAX_STORED_STATES:
                    self._view_states.popitem(last=False)
            for view in views:
                view.request(**changes)
        return len(views)

    def views(self) -> dict[tuple[str, str], View]:
        """The open views by run and name."""
        with self._lock:
            return dict(self._views)

    def forget(self, run_id: str) -> None:
        """Close the views of a run that is removed."""
        self._stop_where(lambda key, view: key[0] == run_id)

    def stop_idle(self) -> None:
        """Stop the views without viewers for ``idle`` seconds; called once a second."""
        now = time.monotonic()
        self._stop_where(lambda key, view: view.clients == 0 and now - view.left_at >= self.idle)
        if self._stopped and now < self._collect_until:
            # viser's objects refer to each other, and a large process collects such old ones too seldom
            gc.collect()

    def close(self) -> None:
        """Stop everything."""
        self._ended.set()
        self._stop_where(lambda key, view: True)

    # ------------------------------------------------------------------------------------------------------ inside

    def _open(self, run_id: str, name: str) -> View:
        data = load_scene3d(self._evidence, run_id, marked_tracks(self._database, run_id))
        with self._database.read() as session:
            run = session.get(Run, run_id)
            title = (run.name if run is not None else "") or "Run"

        def picked(track: int, frame: int) -> None:
            view.request(track=data.key(track), frame=frame)
            self._publish(run_id, {"view": name, "track": data.key(track), "frame": frame})

        def context(scene: viser.SceneApi) -> SceneContext:
            context = context_of(scene, data, self._evidence, self._prior, self._pictograms)
            context.on_pick = picked
            return context

        view = View(
            data,
            context,
            pictures_of(data, self._frames.raw),
            first_view_state(data),
            lambda mode: self._publish(run_id, {"view": name, "mode": mode}),
            title,
        )
        return view

    def _register(self, key: tuple[str, str], view: View) -> bool:
        """Register a new view, unless everything has been stopped meanwhile."""
        with self._lock:
            if self._ended.is_set():
                return False
            view.clients += 1
            self._views[key] = view
            view.request(**self._view_states.get(key, {}))
            if self._reaper is None:
                self._reaper = threading.Thread(target=self._reap, name="tsr-scene3d-idle", daemon=True)
                self._reaper.start()
        return True

    def _publish(self, run_id: str, data: JsonObject) -> None:
        with self._database.write() as session:
            self._events.publish(session, "space", run_id, {"run": run_id, **data})

    @contextmanager
    def _room(self, key: tuple[str, str]) -> Iterator[None]:
        """Keep room for a view that is made in the block; if there is none, the view that was left first ends."""
        with self._lock:
            ended = []
            if len(self._views.keys() | self._reserved) >= MAX_VIEWS:
                idle = [(view.left_at, other) for other, view in self._views.items() if view.clients == 0]
                if not idle:
                    raise Busy(f"{MAX_VIEWS} 3-D views are open, which is the limit. Close one of them.")
                ended = self._remove([min(idle)[1]])
            self._reserved.add(key)
        try:
            for view in ended:
                view.stop()
            yield
        finally:
            with self._lock:
                self._reserved.discard(key)

    def _reap(self) -> None:
        while not self._ended.wait(min(_CHECK_INTERVAL_S, max(0.05, self.idle / 4))):
            self.stop_idle()

    def _stop_where(self, condition: Callable[[tuple[str, str], View], bool]) -> None:
        """Stop some views."""
        with self._lock:
            views = self._remove([key for key, view in self._views.items() if condition(key, view)])
        for view in views:
            view.stop()

    def _remove(self, keys: list[tuple[str, str]]) -> list[View]:
        """Remove views, which the caller stops; the caller holds the lock."""
        views = [self._views.pop(key) for key in keys]
        if views:
            self._stopped.update(views)
            self._collect_until = time.monotonic() + _COLLECT_FOR_S
        return views


def marked_tracks(database: Database, run_id: str) -> frozenset[int]:
    """The engine's tracks that are marked as needing work."""
    with database.read() as session:
        documents = documents_of(session, run_id)
    return frozenset(
        int(key[1:])
        for key, doc in documents.items()
        if doc.review == "needs_work" and key.startswith("m") and key[1:].isdecimal()
    )


def first_view_state(data: Scene3dData) -> ViewState:
    """The first state of a view."""
    first = int(data.frames[0]) if len(data.frames) else 0
    long = len(data.times) > 1 and float(data.times[-1] - data.times[0]) > LONG_RUN_S
    return ViewState(frame=first, stretch=30.0 if long or len(data.ids) > MANY_TRACKS else 0.0)


def context_of(
    scene: viser.SceneApi,
    data: Scene3dData,
    evidence: EvidenceService,
    prior: Callable[[str], Prior | None],
    pictograms: Pictograms,
) -> SceneContext:
    """Make the context of a run's scenes."""

    def detections() -> DetectionPoints:
        with evidence.reading(evidence.stored_run(data.run_id)) as reader:
            return load_detections(reader, data.width, data.height, data.ids)

    def pictogram(name: str) -> Image:
        picture = cv2.imdecode(np.frombuffer(pictograms.png(name, 128), np.uint8), cv2.IMREAD_UNCHANGED)
        assert picture is not None
        return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGRA2RGBA), np.uint8)

    return SceneContext(scene, data, detections, lambda: prior(data.run_id), pictogram)


def pictures_of(data: Scene3dData, raw: Callable[[str, int], Picture]) -> Callable[[int], Image | None]:
    """Return frames of a run's video as RGB, at most ``PICTURE_WIDTH`` px wide."""

    def picture(frame: int) -> Image | None:
        try:
            shown = raw(data.video_id, frame)
        except (ApiError, TsrError):
            return None  # the video is missing: the tracks are shown without it
        if shown.shape[1] > PICTURE_WIDTH:
            height = round(shown.shape[0] * PICTURE_WIDTH / shown.shape[1])
            shown = cv2.resize(shown, (PICTURE_WIDTH, height), interpolation=cv2.INTER_AREA)
        return np.asarray(cv2.cvtColor(shown, cv2.COLOR_BGR2RGB), np.uint8)

    return picture
