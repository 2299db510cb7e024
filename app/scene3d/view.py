"""One open 3-D view: a viser server, a scene, and a thread that draws the newest requested state."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

from app.scene3d.colours import COLOURS, legend_html
from app.scene3d.data import Scene3dData
from app.scene3d.label_spread import FIELD_OF_VIEW_RAD
from app.scene3d.picture_loader import PictureLoader
from app.scene3d.scenes.base import Image, InitialView, Scene, SceneContext
from app.scene3d.scenes.drive import DriveScene
from app.scene3d.scenes.prior import PriorScene
from app.scene3d.scenes.volume import VolumeScene
from app.scene3d.view_state import MODES, Mode, ViewState
from app.scene3d.viser_host import ViserHost

if TYPE_CHECKING:
    import viser

SCENES: dict[Mode, Callable[[SceneContext], Scene]] = {"volume": VolumeScene, "prior": PriorScene, "drive": DriveScene}
_STRETCHES = {"whole run": 0.0, "2 minutes": 120.0, "30 seconds": 30.0, "8 seconds": 8.0}
LONG_RUN_S = 150.0
"""Runs longer than this are first shown 30 s at a time, s."""
MANY_TRACKS = 150
"""Runs with more tracks than this are first shown 30 s at a time."""
_MIN_UPDATE_INTERVAL_S = 0.06
"""Minimum time between updates of the scene, s; a dragged cursor requests many more."""
_PICTURE_TIMEOUT_S = 0.4
"""Maximum wait for a picture before the scene is shown without it, s."""
T = TypeVar("T")
_log = logging.getLogger("tsr.scene3d")


class View:
    """Shows one run to the pages that have opened its address.

    Args:
        data: the run.
        context: makes the context for a scene API.
        picture: returns frame k as RGB; None: not available.
        view_state: first state.
        on_mode: called with another mode that was chosen in viser.
        title: title of the panel.
    """

    def __init__(
        self,
        data: Scene3dData,
        context: Callable[[viser.SceneApi], SceneContext],
        picture: Callable[[int], Image | None],
        view_state: ViewState,
        on_mode: Callable[[Mode], None],
        title: str,
    ) -> None:
        self._data = data
        self._on_mode = on_mode
        self.view_state = view_state
        self.clients = 0
        self.left_at = time.monotonic()
        self._drawn: ViewState | None = None
        self._has_failed = False
        self.scene: Scene | None = None
        self._wakeup = threading.Condition()
        self._ended = False
        self._is_drawn = threading.Event()
        self.host = ViserHost(f"Legend, colours · {title}")  # title of the panel's bar; the panel starts closed
        configure_server(self.host.server)
        self._context = context(self.host.server.scene)
        self.gui = _Gui(self.host.server, self)
        self._is_picture_pending = False
        self._is_picture_ready = False
        self._pictures = PictureLoader(picture, self._on_picture_ready)
        self._thread = threading.Thread(target=self._run, name="tsr-space", daemon=True)
        self._thread.start()

    def request(self, **changes: Any) -> None:  # Any: the fields of ViewState
        """Request changes of the state and return at once; states that were not drawn yet are skipped."""
        with self._wakeup:
            self.view_state = replace(self.view_state, **changes)
            self._is_drawn.clear()
            self._wakeup.notify()

    def wait(self, seconds: float) -> bool:
        """Wait until the newest request is drawn; False: it took longer."""
        return self._is_drawn.wait(seconds)

    def choose_mode(self, mode: Mode) -> None:
        """Change to a scene that was chosen in viser."""
        if mode != self.view_state.mode:
            self.request(mode=mode)
            self._on_mode(mode)

    def stop(self) -> None:
        """End the thread and the server."""
        with self._wakeup:
            self._ended = True
            self._wakeup.notify()
        self._pictures.stop()
        if self._thread is not threading.current_thread():
            self._thread.join(10)
        self.host.stop()

    def _on_picture_ready(self) -> None:
        with self._wakeup:
            self._is_picture_ready = True
            self._wakeup.notify()

    def _run(self) -> None:
        while True:
            with self._wakeup:
                while (
                    not self._ended
                    and self.view_state == self._drawn
                    and not (self._is_picture_pending and self._is_picture_ready)
                ):
                    if not self._is_picture_pending:
                        self._is_drawn.set()
                    self._wakeup.wait()
                if self._ended:
                    return
                view_state, self._is_picture_ready = self.view_state, False
            try:
                self._draw(view_state)
            except Exception:
                if not self._ended:
                    _log.exception("A 3-D view of run %s could not be drawn.", self._data.run_id)
                self._is_picture_pending = False
                self._has_failed = True
            self._drawn = view_state
            time.sleep(_MIN_UPDATE_INTERVAL_S)

    def _draw(self, view_state: ViewState) -> None:
        # Get the picture first, so that the scene is sent together with its picture or without one.
        known, picture = self._pictures.get(view_state.frame, _PICTURE_TIMEOUT_S)
        # A scene that could not be drawn is incomplete, so it is made anew.
        server, before = self.host.server, None if self._has_failed else self._drawn
        with server.atomic():
            changed = self.scene is None or before is None or view_state.mode != before.mode
            if changed:
                former, self.scene, before = self.scene, None, None
                if former is not None:
                    former.clear()
                self.scene = SCENES[view_state.mode](self._context)
            assert self.scene is not None
            look = self.scene.draw(view_state, before)
            self.scene.show(picture)
            if changed:
                place_viewers(server, look)
            self.gui.show(view_state, look)
        server.flush()
        self._is_picture_pending, self._has_failed = not known, False


def configure_server(server: viser.ViserServer) -> None:
    """Configure what all scenes have in common."""
    server.scene.set_up_direction("+z")
    server.scene.world_axes.visible = False
    # Even light: a legend explains the colours, so they must not depend on the direction of a surface.
    server.scene.configure_default_lights(enabled=False)
    server.scene.configure_environment_map(hdri=None)
    server.scene.add_light_ambient("/light/even", intensity=2.2)
    server.scene.add_light_directional("/light/side", intensity=1.1, position=(-6.0, -8.0, 10.0))
    server.initial_camera.fov = FIELD_OF_VIEW_RAD


def place_viewers(server: viser.ViserServer, look: InitialView) -> None:
    """Place every current and later viewer at the best point of view."""
    server.initial_camera.position, server.initial_camera.look_at = look.position, look.look_at
    for client in server.get_clients().values():
        with client.atomic():
            client.camera.position, client.camera.look_at = look.position, look.look_at


class _Gui:
    """viser's panel: settings and legend."""

    def __init__(self, server: viser.ViserServer, view: View) -> None:
        self._view = view
        self._ignores_updates = False
        gui = server.gui
        gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False, control_width="medium")
        names = {text: mode for mode, text in MODES.items()}
        colours = {text: by for by, text in COLOURS.items()}
        view_state = view.view_state
        self.mode = gui.add_dropdown("Scene", tuple(names), initial_value=MODES[view_state.mode])
        self.colour = gui.add_dropdown("Colour", tuple(colours), initial_value=COLOURS[view_state.colour])
        stretch = next((text for text, s in _STRETCHES.items() if s == view_state.stretch), "whole run")
        self.stretch = gui.add_dropdown("Time shown", tuple(_STRETCHES), initial_value=stretch)
        self.angle = gui.add_slider(
            "Camera sees", min=25.0, max=130.0, step=1.0, initial_value=view_state.view, hint="Assumed: degrees across"
        )
        self.size = gui.add_slider(
            "Sign size", min=0.5, max=1.5, step=0.05, initial_value=view_state.size, hint="Assumed: times size class 2"
        )
        self.legend = gui.add_html("")
        # The open panel hides half of a small frame; its bar stays, and a click opens it.
        gui.main_panel.minimize()
        self._reported = ""
        self._listen(self.mode, lambda value: view.choose_mode(names[value]))
        self._listen(self.colour, lambda value: view.request(colour=colours[value]))
        self._listen(self.stretch, lambda value: view.request(stretch=_STRETCHES[value]))
        self._listen(self.angle, lambda value: view.request(view=float(value)))
        self._listen(self.size, lambda value: view.request(size=float(value)))

    def _listen(self, handle: viser.GuiInputHandle[T], act: Callable[[T], None]) -> None:
        @handle.on_update
        def _(_: object) -> None:
            if not self._ignores_updates:
                act(handle.value)

    def show(self, view_state: ViewState, look: InitialView) -> None:
        """Update the panel to the drawn state."""
        self._ignores_updates = True
        try:
            if self.mode.value != MODES[view_state.mode]:
                self.mode.value = MODES[view_state.mode]  # type: ignore[misc]  # handles take it by __setattr__
        finally:
            self._ignores_updates = False
        for handle, mode in (
            (self.colour, "volume"),
            (self.stretch, "volume"),
            (self.angle, "drive"),
            (self.size, "drive"),
        ):
            if handle.visible != (view_state.mode == mode):
                handle.visible = view_state.mode == mode
        text = legend_html(look.title, look.legend, look.notes)
        if text != self._reported:
            self.legend.content = self._reported = text
