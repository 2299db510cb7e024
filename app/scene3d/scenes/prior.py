"""The spatial prior (Eq. 2) as a height field over the picture, with the run's detections."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from app.scene3d.colours import INK, Entry, height_colours, linear
from app.scene3d.geometry import FLAT, grid_lines, surface
from app.scene3d.scenes.base import Image, InitialView, SceneContext, add_lines, remove_nodes
from app.scene3d.view_state import ViewState
from tsr_engine.detection.prior import SpatialPrior, parzen
from tsr_engine.records import FloatArray

if TYPE_CHECKING:
    import viser

DEPTH: Final = 5.0
"""Length of the floor along y, scene units; the picture's height."""
HEIGHT: Final = 2.4
"""Height of the value 1, scene units."""
BANDWIDTH: Final = 0.04
"""Kernel width of the density of the run's detections, as a share of the picture's sides."""
MAX_DENSITY_POINTS: Final = 5_000


class PriorScene:
    """See :class:`app.scene3d.scenes.base.Scene`."""

    def __init__(self, context: SceneContext) -> None:
        self._context = context
        self._root = context.scene.add_frame("/prior", show_axes=False)
        self._width = DEPTH * context.data.width / context.data.height
        self._floor: viser.ImageHandle | None = None
        self._notes: tuple[str, ...] = ()
        self._legend: tuple[Entry, ...] = ()

    def clear(self) -> None:
        """Remove everything from the scene."""
        remove_nodes(self._root)

    def draw(self, view_state: ViewState, before: ViewState | None) -> InitialView:
        """Draw the field once; later calls change only the picture on the floor."""
        if before is None:
            self._draw_field()
        return InitialView(
            position=(-0.62 * self._width, -1.75 * DEPTH, 1.05 * DEPTH),
            look_at=(-0.5, 0.0, 0.3),
            title="Spatial prior against the run",
            legend=self._legend,
            notes=self._notes,
        )

    def show(self, picture: Image | None) -> None:
        """Show the picture on the floor."""
        if picture is None:
            if self._floor is not None:
                self._floor.visible = False
        elif self._floor is None:
            self._floor = self._context.scene.add_image(
                "/prior/picture", picture, self._width, DEPTH, format="jpeg", jpeg_quality=82, wxyz=FLAT,
                position=(0.0, 0.0, -0.02), cast_shadow=False, receive_shadow=False,
            )  # fmt: skip
        else:
            self._floor.image, self._floor.visible = picture, True

    def _draw_field(self) -> None:
        run_prior, detections = self._context.prior(), self._context.detections()
        prior = None if run_prior is None else run_prior.prior
        centres, scene = detections.centres, self._context.scene
        legend: list[Entry] = []
        notes: list[str] = []
        if prior is not None:
            vertices, faces = surface(prior.table, self._width, DEPTH, HEIGHT)
            scene.add_mesh_simple(
                "/prior/surface",
                vertices,
                faces,
                color=(60, 120, 160),
                opacity=0.3,
                side="double",
                cast_shadow=False,
                receive_shadow=False,
            )
            lines, values = grid_lines(prior.table, self._width, DEPTH, HEIGHT, every=8, lift=0.004)
            add_lines(scene, "/prior/cloth", lines, linear(height_colours(values)), 1.6)
            legend += [
                Entry((253, 231, 37), "prior: signs are usual here (1)"),
                Entry((52, 76, 138), "prior: rare (0)"),
            ]
            notes.append(f"Learned weight λ = {prior.weight:.2f}: a score changes by (P - 1/2) λ.")
            if run_prior is not None and not run_prior.is_of_run:
                notes.append("The run was made with another prior, which no longer exists. This is the current one.")
        else:
            notes.append("The models have no spatial prior: only the run's own detections are shown.")
        if len(centres):
            chosen = centres[:: max(1, len(centres) // MAX_DENSITY_POINTS)]
            density_lines, _ = grid_lines(parzen(chosen, BANDWIDTH), self._width, DEPTH, HEIGHT, every=10, lift=0.01)
            high = density_lines[..., 2].max(axis=1) > 0.03 * HEIGHT
            add_lines(scene, "/prior/own", density_lines[high], (235, 240, 248), 1.0)
            legend.append(Entry((235, 240, 248), "where this run's detections are dense"))
        for name, ink, is_shown, text in (
            ("tracked", INK.tracked, detections.tracked, "detection of a confirmed track"),
            ("other", INK.other, ~detections.tracked, "any other detection"),
        ):
            if is_shown.any():
                points = self._on_surface(prior, centres[is_shown])
                scene.add_point_cloud(
                    f"/prior/{name}", points.astype(np.float32), ink, point_size=0.06, point_shape="circle"
                )
                legend.append(Entry(ink, f"{text} ({int(is_shown.sum()):,})"))
        if detections.total > len(centres):
            notes.append(f"{len(centres):,} of {detections.total:,} detections, spread evenly.")
        notes.append("The floor is the picture of the cursor's frame, seen from above its lower edge.")
        self._legend, self._notes = tuple(legend), tuple(notes)
        self._draw_axes()

    def _on_surface(self, prior: SpatialPrior | None, centres: FloatArray) -> FloatArray:
        heights = np.zeros(len(centres))
        if prior is not None:
            heights = prior.at(np.concatenate([centres, centres], axis=1), 1, 1)
        x, y = (centres[:, 0] - 0.5) * self._width, (0.5 - centres[:, 1]) * DEPTH
        return np.stack([x, y, heights * HEIGHT + 0.03], axis=1)

    def _draw_axes(self) -> None:
        scene, w, d = self._context.scene, self._width / 2, DEPTH / 2
        posts = [[[-w, d, 0], [-w, d, HEIGHT]], [[-w, d, 0], [w, d, 0]], [[-w, -d, 0], [-w, d, 0]]]
        posts += [[[-w, -d, 0], [w, -d, 0]], [[w, -d, 0], [w, d, 0]]]
        for value in (0.5, 1.0):
            posts.append([[-w - 0.12, d, value * HEIGHT], [-w, d, value * HEIGHT]])
        add_lines(scene, "/prior/axes", np.array(posts), INK.edge, 1.4)
        for name, text, place, anchor in (
            ("p1", "P = 1", (-w - 0.18, d, HEIGHT), "center-right"),
            ("p05", "0.5", (-w - 0.18, d, HEIGHT / 2), "center-right"),
            ("p0", "0", (-w - 0.18, d, 0.0), "center-right"),
            ("x0", "x = 0", (-w, -d - 0.2, 0.0), "top-center"),
            ("x1", f"x = {self._context.data.width} px", (w, -d - 0.2, 0.0), "top-center"),
            ("y0", "y = 0 (sky)", (w + 0.2, d, 0.0), "center-left"),
            ("y1", f"y = {self._context.data.height} px (road)", (w + 0.2, -d + 0.2, 0.0), "center-left"),
        ):
            scene.add_label(f"/prior/{name}", text, position=place, anchor=anchor)  # type: ignore[arg-type]
