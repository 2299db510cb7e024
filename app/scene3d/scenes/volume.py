"""The space-time volume: picture plane against time, every confirmed track a line, with blocks near the cursor."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from app.scene3d.colours import COLOURS, INK, Paint, linear, paint
from app.scene3d.geometry import UPRIGHT, Volume, block_positions, nice_step, pick_rows, polyline_ids, simplify_lines
from app.scene3d.label_spread import label_text
from app.scene3d.scenes.base import ENGINE_NOTE, Image, InitialView, SceneContext, add_lines, format_time, remove_nodes
from app.scene3d.view_state import ViewState

if TYPE_CHECKING:
    import viser

MAX_CORNERS: Final = 3_000
"""Maximum number of corners of all lines. Without a graphics card every triangle takes 20 us, and a piece of line has
six of them, so 6,000 pieces give one picture per second."""
TOLERANCE: Final = 0.02
"""Maximum deviation of a simplified line, scene units: about one pixel of the screen."""
MAX_BLOCKS: Final = 700
"""Maximum number of blocks, of twelve triangles each."""
BLOCK_RANGE_S: Final = 1.0
"""Seconds to either side of the cursor in which tracks have blocks."""
MIN_BLOCK_SIDE: Final = 0.05
_FACES: Final = np.array(
    [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6],
     [3, 0, 4], [3, 4, 7]], np.uint32
)  # fmt: skip
_CORNERS: Final = np.array(
    [[x, y, z] for z in (-0.5, 0.5) for x, y in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))], np.float32
)


class VolumeScene:
    """See :class:`app.scene3d.scenes.base.Scene`."""

    def __init__(self, context: SceneContext) -> None:
        self._context = context
        self._root = context.scene.add_frame("/volume", show_axes=False)
        self.volume = Volume(context.data.width, context.data.height, 0.0, 1.0)
        self.frame_range = (0, -1)
        self._paint: Paint | None = None
        self._fixed: list[viser.SceneNodeHandle] = []
        self._plane: viser.ImageHandle | None = None
        self._outline: viser.LineSegmentsHandle | None = None
        self._cursor_y = 0.0
        self._label: viser.LabelHandle | None = None
        self.blocks: viser.BatchedMeshHandle | None = None
        self._blocks_version = 0
        self._selection: list[viser.SceneNodeHandle] = []
        self._left_out = 0

    def clear(self) -> None:
        """Remove everything from the scene."""
        remove_nodes(self._root)

    def draw(self, view_state: ViewState, before: ViewState | None) -> InitialView:
        """Update the scene; within the displayed part of the video only the cursor's objects are sent."""
        data = self._context.data
        frame_range = self._displayed_range(view_state)
        is_new = before is None or frame_range != self.frame_range or view_state.colour != before.colour
        if is_new:
            self.frame_range = frame_range
            first, last = data.seconds(np.array(frame_range))
            self.volume = Volume(data.width, data.height, float(first), float(last), depth=12.0)
            self._paint = paint(
                view_state.colour, data.track, data.class_id, data.source, data.verdict, data.sign_names
            )
            self._draw_fixed()
        if is_new or before is None or view_state.frame != before.frame:
            self._draw_cursor(view_state.frame)
        if is_new or before is None or (view_state.frame, view_state.track) != (before.frame, before.track):
            self._draw_blocks(view_state)
            self._draw_selected(view_state)
        assert self._paint is not None
        deep = self.volume.depth
        return InitialView(
            position=(-0.86 * deep, -0.96 * deep, 0.55 * deep),
            look_at=(0.0, 0.0, -0.7),
            title=COLOURS[view_state.colour],
            legend=self._paint.legend,
            notes=self._notes(),
        )

    def _notes(self) -> tuple[str, ...]:
        data = self._context.data
        shown = len(np.unique(data.track[self._within()]))
        notes = [f"{shown:,} of {len(data.ids):,} tracks. Solid: within a second of the cursor, selected or uncertain."]
        notes.append(ENGINE_NOTE)
        if self._left_out:
            notes.append(f"{self._left_out:,} blocks are left out; choose a shorter stretch to see all.")
        return tuple(notes)

    def _displayed_range(self, view_state: ViewState) -> tuple[int, int]:
        """First and last displayed frame. The range moves in steps of half its length, so most cursor moves keep it."""
        data = self._context.data
        if not len(data.frames):
            return 0, 1
        first, last = int(data.frames[0]), int(data.frames[-1])
        length = round(view_state.stretch / data.interval)
        if view_state.stretch <= 0 or length >= last - first:
            return first, max(last, first + 1)
        half = max(1, length // 2)
        begin = first + ((view_state.frame - first) // half) * half - half // 2
        begin = min(max(begin, first), last - length)
        return begin, begin + length

    def _within(self) -> NDArray[np.bool_]:
        frame = self._context.data.frame
        return np.asarray((frame >= self.frame_range[0]) & (frame <= self.frame_range[1]))

    # ------------------------------------------------------------------------------------------- lines and axes

    def _draw_fixed(self) -> None:
        remove_nodes(*self._fixed)
        self._fixed = []
        assert self._paint is not None
        data, volume = self._context.data, self.volume
        rows = np.flatnonzero(self._within())
        points = volume.positions(data.boxes[rows], data.seconds(data.frame[rows]))
        strand, ink = polyline_ids(data.track[rows], data.frame[rows]), self._paint.rows[rows]
        changes = np.zeros(len(rows), np.bool_)
        changes[1:] = (ink[1:] != ink[:-1]).any(axis=1)
        corners = simplify_lines(strand, points, TOLERANCE, MAX_CORNERS, changes)
        points, strand, ink = points[corners], strand[corners], ink[corners]
        starts = np.flatnonzero(np.diff(strand) == 0)
        if len(starts):
            segments = np.stack([points[starts], points[starts + 1]], axis=1)
            colours = linear(ink[starts])
            self._keep(
                add_lines(self._context.scene, "/volume/lines", segments, np.stack([colours, colours], axis=1), 2.2)
            )
        self._draw_box()
        self._draw_ticks()

    def _keep(self, *handles: viser.SceneNodeHandle) -> None:
        self._fixed += handles

    def _draw_box(self) -> None:
        volume = self.volume
        w, h, d = volume.half_width, volume.size / 2, volume.depth / 2
        corners = np.array([[x, y, z] for x in (-w, w) for y in (-d, d) for z in (-h, h)])
        pairs = [(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit]
        edges = np.stack([corners[[a for a, _ in pairs]], corners[[b for _, b in pairs]]], axis=1)
        scene = self._context.scene
        self._keep(
            add_lines(scene, "/volume/box", edges, INK.edge, 1.4),
            scene.add_label("/volume/x", f"x → {volume.width} px", position=(0.0, -d, -h - 0.3), anchor="top-center"),
            scene.add_label(
                "/volume/z", f"y ↓ {volume.height} px", position=(-w - 0.2, -d, 0.0), anchor="center-right"
            ),
        )

    def _draw_ticks(self) -> None:
        volume, scene = self.volume, self._context.scene
        w, h = volume.half_width, volume.size / 2
        step = nice_step(volume.last - volume.first, 8)
        moments = np.arange(np.ceil(volume.first / step - 1e-9), np.floor(volume.last / step + 1e-9) + 1) * step
        floor = []
        for i, (moment, y) in enumerate(zip(moments.tolist(), volume.along(moments).tolist(), strict=True)):
            floor += [[[-w, y, -h], [w, y, -h]], [[-w, y, -h], [-w, y, h]]]
            text = format_time(moment, tenths=step < 1)
            self._keep(scene.add_label(f"/volume/t{i}", text, position=(w + 0.25, y, -h), anchor="center-left"))
        if floor:
            self._keep(add_lines(scene, "/volume/floor", np.array(floor), INK.tick, 1.0))
        end = volume.depth / 2
        self._keep(scene.add_label("/volume/t", "time →", position=(-w, end, h + 0.15), anchor="bottom-center"))

    # ------------------------------------------------------------------------------------------------ the cursor

    def show(self, picture: Image | None) -> None:
        """Show the picture at its time."""
        volume = self.volume
        if picture is None:
            if self._plane is not None:
                self._plane.visible = False
        elif self._plane is None:
            self._plane = self._context.scene.add_image(
                "/volume/frame", picture, 2 * volume.half_width, volume.size, format="jpeg", jpeg_quality=82,
                wxyz=UPRIGHT, position=(0.0, self._cursor_y, 0.0), cast_shadow=False, receive_shadow=False,
            )  # fmt: skip
        else:
            self._plane.image, self._plane.position, self._plane.visible = picture, (0.0, self._cursor_y, 0.0), True

    def _draw_cursor(self, frame: int) -> None:
        """The outline of the current frame, with its number."""
        volume, scene = self.volume, self._context.scene
        at = float(self._context.data.seconds(frame))
        self._cursor_y = float(volume.along(at))
        w, h = volume.half_width, volume.size / 2
        text, place = f"frame {frame} · {format_time(at, tenths=True)}", (0.0, self._cursor_y, h + 0.08)
        if self._label is None or self._outline is None:
            corners = np.array([[-w, 0, -h], [w, 0, -h], [w, 0, h], [-w, 0, h]])
            edges = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
            self._outline = add_lines(scene, "/volume/outline", edges, INK.frame, 2.0)
            self._label = scene.add_label("/volume/now", text, position=place, anchor="bottom-center")
        else:
            self._label.text, self._label.position = text, place
        self._outline.position = (0.0, self._cursor_y, 0.0)

    def _draw_blocks(self, view_state: ViewState) -> None:
        data = self._context.data
        assert self._paint is not None
        visible = np.flatnonzero(self._within())
        selected = data.position(view_state.track)
        always = data.flagged.copy()
        if selected is not None:
            always[selected] = True
        max_distance = max(1, round(BLOCK_RANGE_S / data.interval))
        picked, self._left_out = pick_rows(
            data.frame[visible], data.track[visible], view_state.frame, max_distance, always, MAX_BLOCKS
        )
        rows = visible[picked]
        remove_nodes(self.blocks)
        self.blocks = None
        if not len(rows):
            return
        # A click names the node, so new blocks need a new name: a click on replaced blocks must not hit them.
        self._blocks_version = (self._blocks_version + 1) % 32
        positions, sizes = block_positions(
            self.volume, data.boxes[rows], data.seconds(data.frame[rows]), data.interval, MIN_BLOCK_SIDE
        )
        ink = self._paint.rows[rows].astype(np.float64)
        if selected is not None:
            is_selected = data.track[rows] == selected
            ink[is_selected] = ink[is_selected] * 0.45 + 255 * 0.55
        self.blocks = self._context.scene.add_batched_meshes_simple(
            f"/volume/beads{self._blocks_version}", _CORNERS, _FACES, np.tile([1.0, 0.0, 0.0, 0.0], (len(rows), 1)),
            positions, batched_scales=sizes.astype(np.float32), batched_colors=linear(ink), lod="off",
            flat_shading=True, cast_shadow=False, receive_shadow=False,
        )  # fmt: skip

        @self.blocks.on_click  # type: ignore[untyped-decorator]
        def _(event: viser.SceneNodePointerEvent[viser.BatchedMeshHandle]) -> None:
            i = event.instance_index
            if i is not None and 0 <= i < len(rows):
                self._context.on_pick(int(data.track[rows[i]]), int(data.frame[rows[i]]))

    def _draw_selected(self, view_state: ViewState) -> None:
        remove_nodes(*self._selection)
        self._selection = []
        data = self._context.data
        chosen = data.position(view_state.track)
        rows = np.flatnonzero(self._within() & (data.track == chosen)) if chosen is not None else np.zeros(0, np.int64)
        if chosen is None or not len(rows):
            return
        points = self.volume.positions(data.boxes[rows], data.seconds(data.frame[rows]))
        if len(rows) > 1:
            segments = np.stack([points[:-1], points[1:]], axis=1)
            self._selection.append(add_lines(self._context.scene, "/volume/chosen", segments, INK.selected, 5.0))
        sign = data.sign(chosen)
        name = "not recognised" if sign is None else sign.name
        self._selection.append(
            self._context.scene.add_label(
                "/volume/name",
                label_text(name, data.name(chosen)),
                position=tuple(points[-1] + (0, 0, 0.3)),
                anchor="bottom-center",
            )
        )
