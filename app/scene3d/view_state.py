"""The state that a viewer requests: a small immutable value; only the newest one is drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from app.scene3d.colours import Colouring

Mode = Literal["volume", "prior", "drive"]
MODES: Final[dict[Mode, str]] = {"volume": "Space-time volume", "prior": "Spatial prior", "drive": "Metric drive"}


@dataclass(frozen=True, slots=True)
class ViewState:
    """One state of a view of a run.

    Attributes:
        frame: ordinal of the cursor.
        track: key of the selected track.
        mode: the scene.
        colour: property that colours show in the volume.
        stretch: seconds of video in the volume around the cursor; 0: the whole run.
        view: assumed horizontal field of view of the camera, degrees.
        size: assumed size of all signs, as a factor of the catalogue's.
    """

    frame: int = 0
    track: str | None = None
    mode: Mode = "volume"
    colour: Colouring = "class"
    stretch: float = 0.0
    view: float = 60.0
    size: float = 1.0
