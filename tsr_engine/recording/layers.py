"""Defines paths and appearance of a recording's layers in one table for writer, blueprint, tests and documentation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

FRAME_TIMELINE: Final = "frame"
"""Timeline of ordinals."""
TIME_TIMELINE: Final = "time"
"""Timeline of presentation times."""
VIDEO: Final = "video"
"""Entity of the picture; the layers lie below it in the tree, so that they are drawn over it."""
EVENTS: Final = "events"

Rgb = tuple[int, int, int]
"""A colour, 0 to 255 each."""


@dataclass(frozen=True, slots=True)
class Layer:
    """One kind of box over the picture.

    Attributes:
        name: last part of the entity path.
        title: title for people.
        colour: colour of all its boxes; None: the colour of each box's class.
        radius: half the line width, in points of the screen.
        shown: whether it is visible when the recording opens.
        labelled: whether each box shows its label; otherwise only the box under the pointer does.
    """

    name: str
    title: str
    colour: Rgb | None
    radius: float
    shown: bool = True
    labelled: bool = False

    @property
    def entity(self) -> str:
        """Entity path."""
        return f"{VIDEO}/{self.name}"


LAYERS: Final = {
    layer.name: layer
    for layer in (
        Layer("detections_raw", "detections, score before the prior", (86, 180, 233), 0.7, shown=False),
        Layer("detections", "detections, score with the prior", (86, 180, 233), 0.7),
        Layer("predictions", "predictions of the motion model", (240, 228, 66), 0.7),
        Layer("innovation", "1-sigma box of the predicted centre", (240, 228, 66), 0.4),
        Layer("search", "what the online detector searched", (204, 121, 167), 0.4),
        Layer("relocalisations", "what the online detector found", (230, 159, 0), 0.9),
        Layer("runner_up", "second best window of the online detector", (230, 159, 0), 0.4, shown=False),
        Layer("results", "results of the run", None, 1.2, labelled=True),
        Layer("corrected", "corrected annotation", None, 1.8, labelled=True),
        Layer("truth", "ground truth", (255, 255, 255), 0.9),
    )
}
"""Layers by name; their colours are those of the review screen."""

TAU_COLOUR: Final[Rgb] = (230, 60, 60)
TRACK_COLOURS: Final[tuple[Rgb, ...]] = (
    (80, 150, 255),
    (255, 165, 40),
    (60, 190, 90),
    (205, 120, 255),
    (250, 230, 80),
    (0, 215, 220),
    (255, 130, 175),
    (165, 115, 65),
    (235, 235, 235),
    (120, 95, 190),
    (175, 235, 160),
    (130, 130, 20),
)
"""Line colours of plots in the order of tracks, different from the threshold's: a viewer's own may give two tracks
nearly the same colour."""


def track_entity(track_id: int, *parts: str) -> str:
    """Entity path below that of one track."""
    return "/".join(("tracks", f"m{track_id}", *parts))
