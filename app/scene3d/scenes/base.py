"""Inputs and outputs of all scenes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from app.scene3d.colours import ByteArray, Entry, Rgb
from app.scene3d.data import DetectionPoints, Scene3dData
from app.scene3d.prior import Prior
from app.scene3d.view_state import ViewState
from tsr_engine.records import FloatArray

if TYPE_CHECKING:
    import viser

Image = NDArray[np.uint8]
ENGINE_NOTE = "Boxes and classes are the engine's; corrections are not drawn."
"""A note of the scenes that show tracks."""


@dataclass(frozen=True, slots=True)
class InitialView:
    """The first point of view, and the meaning of colours."""

    position: tuple[float, float, float]
    look_at: tuple[float, float, float]
    title: str
    legend: tuple[Entry, ...]
    notes: tuple[str, ...]


@dataclass(slots=True)
class SceneContext:
    """The target and the data of a scene.

    Attributes:
        scene: viser's scene.
        data: the run.
        detections: the run's detections.
        prior: the spatial prior in use; None: there is none.
        pictogram: returns a drawing (see ``Label.pictogram``) as RGBA.
        on_pick: called with the track (its index) and the frame that was clicked.
    """

    scene: viser.SceneApi
    data: Scene3dData
    detections: Callable[[], DetectionPoints]
    prior: Callable[[], Prior | None]
    pictogram: Callable[[str], Image]
    on_pick: Callable[[int, int], None] = lambda track, frame: None


class Scene(Protocol):
    """One of the three scenes."""

    def draw(self, view_state: ViewState, before: ViewState | None) -> InitialView:
        """Update the scene.

        Args:
            view_state: state to draw.
            before: state of the last call; None: nothing is drawn yet.
        """

    def show(self, picture: Image | None) -> None:
        """Show the picture of the frame that was drawn last; None: it is not available (yet), so show none."""

    def clear(self) -> None:
        """Remove everything from the scene."""


def add_lines(
    scene: viser.SceneApi, name: str, segments: FloatArray, colours: Rgb | ByteArray, width: float
) -> viser.LineSegmentsHandle:
    """Add segments, shape (n, 2, 3), with lines of a width in px of the screen."""
    return scene.add_line_segments(name, segments, colours, thickness=width, thickness_units="screen")


def remove_nodes(*handles: viser.SceneNodeHandle | None) -> None:
    """Remove those handles that exist."""
    for handle in handles:
        if handle is not None:
            handle.remove()


def format_time(seconds: float, tenths: bool = False) -> str:
    """Format seconds as ``m:ss``, optionally with tenths."""
    sign, value = ("-" if seconds < 0 else ""), abs(seconds)
    minutes, rest = divmod(round(value, 1) if tenths else round(value), 60)
    return f"{sign}{int(minutes)}:{rest:04.1f}" if tenths else f"{sign}{int(minutes)}:{int(rest):02d}"
