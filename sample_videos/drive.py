"""A drive: the road, the objects beside it, other vehicles, and our car's position over time."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sample_videos.ground import RoadStyle
from sample_videos.meshes import Body, Mesh
from sample_videos.road_path import RoadPath
from sample_videos.scenarios import Scenario
from sample_videos.scene_objects import SceneObject
from sample_videos.sign_posts import Sign
from sample_videos.weather import Weather
from tsr_engine.json_shapes import JsonObject

Array = NDArray[np.float64]
LANE = 1.75
"""Distance of a lane's middle from the centre line, metres."""


@dataclass
class MovingVehicle:
    """A moving vehicle.

    Attributes:
        mesh: Its body.
        s0: Arc length at the start.
        d: Distance to the right of the centre line.
        speed: Along the road's direction; negative: oncoming.
    """

    mesh: Mesh
    s0: float
    d: float
    speed: float

    def body(self, path: RoadPath, t: float) -> Body | None:
        """The body at a time; None: off the road's known length."""
        s = self.s0 + self.speed * t
        if not -path.BEHIND < s < path.length:
            return None
        right, forward = path.frame(s)
        if self.speed < 0:
            right, forward = -right, -forward
        return Body(self.mesh, path.point(s, self.d), right, forward, velocity=forward * abs(self.speed))


@dataclass
class Drive:
    """Everything that is needed to paint a drive.

    Attributes:
        scenario: Its kind.
        weather: Light and air.
        style: Cross-section of the road.
        path: The road's centre line.
        things: Static objects, with the distance up to which each is painted.
        signs: The signs, which are also among the things.
        movers: Other vehicles.
        bridge: Arc lengths of the bridge's start and end, and its frame, or None.
        bumps: Times and strengths of jolts.
        distractors: Objects that look like signs: kind and place.
    """

    scenario: Scenario
    weather: Weather
    style: RoadStyle
    path: RoadPath
    things: list[tuple[SceneObject, float]] = field(default_factory=list)
    signs: list[Sign] = field(default_factory=list)
    movers: list[MovingVehicle] = field(default_factory=list)
    bridge: tuple[float, float] | None = None
    bumps: list[tuple[float, float]] = field(default_factory=list)
    distractors: list[JsonObject] = field(default_factory=list)

    def distance(self, t: float) -> float:
        """Arc length of our car at a time in seconds."""
        v = self.scenario.speed
        return float(v * (t + 0.22 * (1 - np.cos(0.5 * t))))

    def speed(self, t: float) -> float:
        """Our speed at a time, metres per second."""
        return float(self.scenario.speed * (1 + 0.11 * np.sin(0.5 * t)))

    def time_at(self, s: float) -> float:
        """Time at which our car is at an arc length."""
        low, high = 0.0, s / self.scenario.speed * 1.5 + 5
        for _ in range(50):
            middle = (low + high) / 2
            low, high = (middle, high) if self.distance(middle) < s else (low, middle)
        return (low + high) / 2
