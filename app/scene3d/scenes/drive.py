"""The metric drive: the camera with its picture, and signs of known size placed by ``Z = f D / w``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from app.scene3d.colours import INK, Entry, Paint, linear, paint
from app.scene3d.data import UNKNOWN_SIZE
from app.scene3d.geometry import UPRIGHT, Camera, focal_length, frustum_scale, metric_positions
from app.scene3d.label_spread import label_offsets, label_text
from app.scene3d.scenes.base import ENGINE_NOTE, Image, InitialView, SceneContext, add_lines, remove_nodes
from app.scene3d.view_state import ViewState
from tsr_engine.records import FloatArray

if TYPE_CHECKING:
    import viser

ROAD_LENGTH_M: Final = 80.0
"""Length of the drawn road, m."""
LABELLED_DISTANCES_M: Final = (10, 20, 30, 50, 80)
"""Distances of the labelled lines on the road, m; further labels would overlap."""
CAMERA_HEIGHT: Final = 1.3
"""Assumed height of the camera above the road, m."""
PICTURE_DISTANCE_M: Final = 5.0
"""Distance at which the frustum's picture stands, m."""
PATH_RANGE_S: Final = 4.0
"""Tracks that are alive within this many seconds of the cursor show their paths."""
EYE: Final = (-8.5, -13.0, 7.5)
TARGET: Final = (1.0, 16.0, -0.5)
"""First position of the viewer, and the point that they look at."""
MAX_DISTANCE_M: Final = 250.0
MAX_SIGNS: Final = 24
PICTOGRAM_SCALE: Final = 2.0
"""Factor by which pictograms are larger than the signs, because small ones cannot be distinguished."""


class DriveScene:
    """See :class:`app.scene3d.scenes.base.Scene`. World axes in metres: right, ahead, up; the camera is the origin."""

    def __init__(self, context: SceneContext) -> None:
        self._context = context
        self._root = context.scene.add_frame("/drive", show_axes=False)
        data = context.data
        self._paint: Paint = paint("class", data.track, data.class_id, data.source, data.verdict, data.sign_names)
        self._camera = Camera(data.width, data.height, focal_length(data.width, 60.0))
        self._frustum: viser.CameraFrustumHandle | None = None
        self._moving: list[viser.SceneNodeHandle] = []
        self._draw_road()

    def clear(self) -> None:
        """Remove everything from the scene."""
        remove_nodes(self._root)

    def draw(self, view_state: ViewState, before: ViewState | None) -> InitialView:
        """Update the scene."""
        data = self._context.data
        if before is None or view_state.view != before.view:
            self._camera = Camera(data.width, data.height, focal_length(data.width, view_state.view))
            self._draw_camera()
        if before is None or _drawn_state(view_state) != _drawn_state(before):
            self._draw_signs(view_state)
        return InitialView(
            position=EYE,
            look_at=TARGET,
            title="Metric drive: classes",
            legend=(*self._paint.legend, Entry(INK.selected, "selected")),
            notes=(
                f"Assumed: the camera sees {view_state.view:g}° across (f = {self._camera.focal:.0f} px), signs are "
                f"{view_state.size:g} times size class 2 (discs 0.60 m, triangles and stop 0.90 m).",
                "Z = f D / w. Bright: seen so far; faint: later. Pictograms are drawn twice as large as the signs.",
                ENGINE_NOTE,
            ),
        )

    def _draw_road(self) -> None:
        scene, low = self._context.scene, -CAMERA_HEIGHT
        lines = [[[x, 0, low], [x, ROAD_LENGTH_M, low]] for x in (-10.0, -5.0, 0.0, 5.0, 10.0)]
        lines += [[[-10, y, low], [10, y, low]] for y in np.arange(0, ROAD_LENGTH_M + 1, 10.0)]
        add_lines(scene, "/drive/road", np.array(lines), INK.road, 1.4)
        for metres in LABELLED_DISTANCES_M:
            scene.add_label(
                f"/drive/m{metres}", f"{metres} m", position=(10.6, float(metres), low), anchor="center-left"
            )

    def show(self, picture: Image | None) -> None:
        """Show the picture in the frustum."""
        if self._frustum is not None:
            self._frustum.image = picture

    def _draw_camera(self) -> None:
        remove_nodes(self._frustum)
        self._frustum = self._context.scene.add_camera_frustum(
            "/drive/camera", self._camera.vertical_view, self._camera.width / self._camera.height,
            scale=frustum_scale(self._camera, PICTURE_DISTANCE_M), thickness=2.0, thickness_units="screen",
            color=INK.camera, format="jpeg", jpeg_quality=82, wxyz=UPRIGHT, cast_shadow=False, receive_shadow=False,
        )  # fmt: skip

    def _draw_signs(self, view_state: ViewState) -> None:
        remove_nodes(*self._moving)
        self._moving = []
        data, scene = self._context.data, self._context.scene
        reach = round(PATH_RANGE_S / data.interval)
        near = np.unique(data.track[np.abs(data.frame - view_state.frame) <= reach])
        chosen = data.position(view_state.track)
        if chosen is not None:
            near = np.union1d(near, [chosen])
        if len(near) > MAX_SIGNS:
            present = np.unique(data.track[data.frame == view_state.frame])
            order = np.lexsort((near, near != (-1 if chosen is None else chosen), ~np.isin(near, present)))
            near = near[order[:MAX_SIGNS]]
        past, future = [], []
        here_now: list[tuple[int, FloatArray, float]] = []
        for track in near.tolist():
            rows = np.flatnonzero(data.track == track)
            sign = data.sign(track)
            size = (UNKNOWN_SIZE if sign is None else sign.size) * view_state.size
            places = metric_positions(self._camera, data.boxes[rows], size)
            far = places[:, 1] > MAX_DISTANCE_M
            segments = np.stack([places[:-1], places[1:]], axis=1)[~(far[:-1] | far[1:])]
            ends = data.frame[rows][1:][~(far[:-1] | far[1:])]
            ink = np.array(INK.selected if track == chosen else self._paint.rows[rows[0]], np.float64)
            past.append((segments[ends <= view_state.frame], ink))
            future.append((segments[ends > view_state.frame], ink * 0.45))
            here = np.flatnonzero(data.frame[rows] == view_state.frame)
            if len(here) and not far[here[0]]:
                here_now.append((track, places[here[0]], size))
        self._draw_present(here_now, chosen)
        for name, parts, width in (("past", past, 3.0), ("future", future, 1.6)):
            lines = [s for s, _ in parts if len(s)]
            if not lines:
                continue
            inks = [np.tile(ink, (len(s), 2, 1)) for s, ink in parts if len(s)]
            self._moving.append(
                add_lines(scene, f"/drive/{name}", np.concatenate(lines), linear(np.concatenate(inks)), width)
            )

    def _draw_present(self, signs: list[tuple[int, FloatArray, float]], chosen: int | None) -> None:
        """Draw the signs of this frame, with labels that do not overlap."""
        data = self._context.data
        texts = []
        for track, place, _ in signs:
            sign = data.sign(track)
            name = "not recognised" if sign is None else sign.name
            texts.append(label_text(name, data.name(track), f"{place[1]:.1f} m"))
        tops = np.array(
            [place + np.array([0, 0, size * PICTOGRAM_SCALE / 2 + 0.1]) for _, place, size in signs]
        ).reshape(-1, 3)
        raised = label_offsets(tops, texts, EYE, TARGET)
        for (track, place, size), text, top, lift in zip(signs, texts, tops, raised.tolist(), strict=True):
            self._draw_sign(track, place, size, track == chosen)
            self._draw_label(track, text, top, lift)

    def _draw_label(self, track: int, text: str, top: FloatArray, lift: float) -> None:
        scene, at = self._context.scene, top + np.array([0, 0, lift])
        x, y, z = (float(v) for v in at)
        self._moving.append(scene.add_label(f"/drive/label{track}", text, position=(x, y, z), anchor="bottom-center"))
        if lift > 0:
            line = np.array([[top, at]])
            self._moving.append(add_lines(scene, f"/drive/lead{track}", line, INK.road, 1.0))

    def _draw_sign(self, track: int, place: FloatArray, size: float, chosen: bool) -> None:
        data, scene = self._context.data, self._context.scene
        x, y, z = (float(v) for v in place)
        sign = data.sign(track)
        side = size * PICTOGRAM_SCALE
        if sign is not None and sign.pictogram:
            self._moving.append(
                scene.add_image(
                    f"/drive/sign{track}",
                    self._context.pictogram(sign.pictogram),
                    side,
                    side,
                    format="png",
                    wxyz=UPRIGHT,
                    position=(x, y, z),
                    cast_shadow=False,
                    receive_shadow=False,
                )
            )
        foot = np.array(
            [[[x, y, -CAMERA_HEIGHT], [x, y, z]], [[x - 0.4, y, -CAMERA_HEIGHT], [x + 0.4, y, -CAMERA_HEIGHT]]]
        )
        colour = self._paint.rows[int(np.flatnonzero(data.track == track)[0])]
        ink = INK.selected if chosen else (int(colour[0]), int(colour[1]), int(colour[2]))
        self._moving.append(add_lines(scene, f"/drive/foot{track}", foot, ink, 2.0))


def _drawn_state(view_state: ViewState) -> tuple[object, ...]:
    """The values that positions and highlights of signs depend on."""
    return view_state.frame, view_state.track, view_state.view, view_state.size
