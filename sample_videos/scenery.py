"""Builds a drive: places signs, plants, buildings and other vehicles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from sample_videos import sign_lookalikes, structures, vegetation, vehicles
from sample_videos.drive import LANE, Drive, MovingVehicle
from sample_videos.ground import COUNTRY, TOWN
from sample_videos.linear_canvas import Patch
from sample_videos.meshes import Body, Mesh
from sample_videos.pole_plan import plan_poles
from sample_videos.road_path import RoadPath
from sample_videos.scenarios import Scenario
from sample_videos.scene_objects import UP, Billboard, Plate, SceneObject, rectangle
from sample_videos.sign_posts import build_sign_post
from sample_videos.weather import WEATHERS


class _Builder:
    """Fills a drive; one method per kind of object."""

    def __init__(self, drive: Drive, rng: np.random.Generator, last: float) -> None:
        self.drive, self.rng, self.last = drive, rng, last
        self.end = last + 380.0
        w = drive.weather
        self.trees = [
            vegetation.broadleaf(rng, w, slim=float(rng.uniform(0.75, 1.0)), clear=float(rng.uniform(0.08, 0.24)))
            for _ in range(6)
        ]
        self.conifers = [vegetation.conifer(rng, w) for _ in range(2)]
        self.bushes = [vegetation.bush(rng, w) for _ in range(4)]
        self.hedges = [vegetation.hedge(rng, w) for _ in range(2)]
        self.groves = [vegetation.grove(rng, self.trees + self.conifers) for _ in range(3)]
        self.tufts = [vegetation.tuft(rng, w) for _ in range(4)]

    def add(self, thing: SceneObject, reach: float) -> None:
        self.drive.things.append((thing, reach))

    def stand(
        self, build: Callable[..., SceneObject], s: float, d: float, reach: float, *further: float | bool
    ) -> None:
        """Add what ``build`` makes of a place beside the road and the road's axes there."""
        self.add(build(self.drive.path.point(s, d), *self.drive.path.frame(s), *further), reach)

    def _pick(self, pictures: list[list[Patch]]) -> list[Patch]:
        return pictures[int(self.rng.integers(len(pictures)))]

    def free(self, s: float, d: float, margin: float = 2.5) -> bool:
        """Whether an object may stand here: not under a bridge, and not between us and a sign."""
        bridge = self.drive.bridge
        if bridge is not None and bridge[0] - 14 < s < bridge[1] + 10 and abs(d) < 70:
            return False
        return all(
            not (sign.s - 45 < s < sign.s + 1.5 and d * sign.d > 0 and abs(d) < abs(sign.d) + margin)
            for sign in self.drive.signs
        )

    def tree(self, s: float, d: float, tall: float, reach: float = 420.0, *, conifer: bool = False) -> None:
        pictures, wide = (self.conifers, tall * 0.45) if conifer else (self.trees, tall * 0.8)
        self.add(Billboard(self.drive.path.point(s, d), self._pick(pictures), wide, tall), reach)

    def wood(self, s: float, d: float, tall: float) -> None:
        self.add(Billboard(self.drive.path.point(s, d), self._pick(self.groves), tall * 3.4, tall, shades=False), 800)

    def bush(self, s: float, d: float, tall: float, reach: float = 300.0) -> None:
        self.add(Billboard(self.drive.path.point(s, d), self._pick(self.bushes), tall * 1.3, tall), reach)

    def plate(
        self,
        kind: str,
        picture: list[Patch],
        s: float,
        d: float,
        size: tuple[float, float],
        low: float,
        *,
        on_pole: bool = True,
        turn: float = 0.0,
    ) -> None:
        """Add a distractor that faces us."""
        path = self.drive.path
        right, forward = path.frame(s)
        across = right * np.cos(turn) + forward * np.sin(turn)
        foot = path.point(s, d)
        w, h = size
        centre = foot + UP * (low + h / 2) - forward * 0.08
        self.add(Plate(rectangle(centre, across * w / 2, UP * h / 2), picture, shades=True), 260)
        if on_pole:
            if w > 1.2:
                for side in (-0.4, 0.4):
                    self.add(structures.pole(foot + across * w * side, across, forward, low + h, 0.06), 260)
            else:
                self.add(structures.pole(foot, across, forward, low + h), 160)
        self.drive.distractors.append({"kind": kind, "s": round(s, 1), "d": round(d, 2)})

    def posts(self) -> None:
        """Add the signs on their poles."""
        d, rng = self.drive, self.rng
        for pole in plan_poles(d.scenario, d.bridge, self.last, rng):
            signs, mast = build_sign_post(rng, d.path, pole.s, pole.d, list(pole.classes), len(d.signs) + 1, 0.0)
            d.signs += signs
            for sign in signs:
                self.add(sign, 200)
            self.add(mast, 160)
            if pole.hidden:
                self._hide(pole.s, pole.d)
            if pole.met:
                self._meet(pole.s)

    def _hide(self, s: float, where: float) -> None:
        if self.drive.scenario.town:
            path = self.drive.path
            right, forward = path.frame(s - 13)
            body = Body(Mesh(vehicles.van(self.rng, lit=False)), path.point(s - 13, 4.12), right, forward)
            self.add(body, 220)
            return
        self.bush(s - 8.5, where - 0.45, 3.3)
        self.bush(s - 7.6, where + 0.8, 2.6)

    def _meet(self, s: float) -> None:
        """Add an oncoming lorry that is between us and a sign on the left when the sign is 34 m away."""
        d = self.drive
        t = d.time_at(s - 34)
        lorry = Mesh(vehicles.lorry(self.rng, lit=d.weather.lamps))
        d.movers.append(MovingVehicle(lorry, s - 34 + 17 + 17.0 * t, -LANE - 0.1, -17.0))

    def traffic(self) -> None:
        """Add other vehicles: one ahead of us, some oncoming."""
        d, rng, sc = self.drive, self.rng, self.drive.scenario
        lit = d.weather.lamps or d.weather.name == "low_sun"
        car = Mesh(vehicles.car(rng, lit=lit, paint=(150, 18, 24)))
        d.movers.append(MovingVehicle(car, 46.0 if sc.town else 62.0, LANE, sc.speed * 1.015))
        t = 0.8
        total = d.time_at(self.last)
        while t < total:
            meet = d.distance(t)
            speed = -sc.speed * float(rng.uniform(0.9, 1.1))
            kind = vehicles.car if rng.random() < 0.75 else vehicles.van
            start = meet - speed * t
            if all(abs(start + speed * t - m.s0 - m.speed * t) > 16 for m in d.movers if m.speed < 0):
                d.movers.append(MovingVehicle(Mesh(kind(rng, lit=lit)), start, -LANE, speed))
            t += float(rng.uniform(1.6, 4.2))

    def country(self) -> None:
        """Add trees, hedges, bales, rails, kerb posts, poles, farms and sign-like boards along a country road."""
        rng, d = self.rng, self.drive
        path = d.path
        for s in np.arange(-20.0, self.end, 25.0):
            for side in (-1, 1):
                self.stand(structures.delineator, s, side * 4.35, 170)
        s = -10.0
        while s < self.end:
            kind = rng.random()
            side = 1 if rng.random() < 0.5 else -1
            run = float(rng.uniform(25, 80))
            if kind < 0.40:
                for q in np.arange(s, s + run, rng.uniform(7, 12)):
                    at, off = q + rng.uniform(-1, 1), side * rng.uniform(8.5, 10.5)
                    if self.free(at, off):
                        self.tree(at, off, rng.uniform(7, 13))
            elif kind < 0.75:
                for q in np.arange(s, s + run * 1.2, 2.6):
                    for _ in range(2):
                        off = side * rng.uniform(14, 30)
                        if self.free(q, off):
                            self.tree(q + rng.uniform(-2, 2), off, rng.uniform(8, 16), conifer=rng.random() < 0.3)
                    if rng.random() < 0.6 and self.free(q, 12.5):
                        self.bush(q, side * rng.uniform(12, 14), rng.uniform(1.4, 2.6))
            else:
                for q in np.arange(s, s + run, 2.4):
                    if self.free(q, side * 9.0):
                        self.bush(q, side * rng.uniform(9.0, 10.5), rng.uniform(1.2, 2.8))
            s += run * float(rng.uniform(0.4, 0.9))
        for q in np.arange(-20.0, self.end + 300, 16.0):
            for side in (-1, 1):
                deep = 95 + 60 * np.sin(q / 90 + side) + rng.uniform(-6, 6)
                if rng.random() < 0.8:
                    self.wood(q, side * deep, rng.uniform(9, 13))
                if rng.random() < 0.5:
                    self.wood(q, side * (deep + 70), rng.uniform(11, 15))
                if rng.random() < 0.3:
                    at, off, tall = q + rng.uniform(-6, 6), side * rng.uniform(40, 90), rng.uniform(7, 13)
                    self.tree(at, off, tall, 600, conifer=rng.random() < 0.25)
        for q in np.arange(10.0, self.end, 47.0):
            self.stand(structures.wooden_pole, q, -13.5, 360)
        for q in rng.uniform(20, self.end, int(self.end / 28)):
            self.stand(structures.bale, q, float(rng.choice([-1, 1])) * rng.uniform(15, 45), 260)
            d.distractors.append({"kind": "bale", "s": round(float(q), 1)})
        start = float(rng.uniform(0.35, 0.5)) * self.last
        for q in np.arange(start, start + 56, 4.0):
            self.stand(structures.rail, q, -4.6, 160, 4.0)
        for q in np.arange(95, self.end, 150):
            side = -1 if rng.random() < 0.6 else 1
            right, forward = path.frame(q)
            for k in range(int(rng.integers(1, 4))):
                angle = rng.uniform(-0.6, 0.6)
                r, f = right * np.cos(angle) + forward * np.sin(angle), forward * np.cos(angle) - right * np.sin(angle)
                centre = path.point(q + 16 * k, side * rng.uniform(26, 44))
                self.add(structures.House(rng, centre, r, f, d.weather.lamps), 500)
        self.plate("poster", sign_lookalikes.poster(rng), 118.0, -9.0, (3.4, 2.4), 1.2)
        self.plate("direction", sign_lookalikes.direction(rng), 84.0, 6.6, (1.9, 0.9), 1.5)
        self.plate("sign_back", sign_lookalikes.sign_back(9), 172.0, -5.0, (0.6, 0.6), 2.0)
        self.plate("sign_back", sign_lookalikes.sign_back(20), 128.0, -5.1, (0.9, 0.9), 1.9)
        self.plate("bend_marker", sign_lookalikes.chevrons(), 236.0, -5.6, (0.9, 0.9), 0.9)
        for q in np.arange(300, self.end, 130):
            poster, off = sign_lookalikes.poster(rng), float(rng.choice([-1, 1])) * 9.5
            self.plate("poster", poster, float(q), off, (3.2, 2.2), 1.2)

    def town(self) -> None:
        """Add houses with gardens, hedges, trees, lamps, parked cars and sign-like boards along a street."""
        rng, d = self.rng, self.drive
        path, lit = d.path, d.weather.lamps
        for side in (-1, 1):
            q = -8.0
            while q < self.end:
                if self.free(q, side * 14, 0):
                    right, forward = path.frame(q)
                    across, along = (forward, right) if rng.random() < 0.65 else (right, forward)
                    centre = path.point(q, side * rng.uniform(13.5, 16.5))
                    self.add(structures.House(rng, centre, across, along, lit), 420)
                    if rng.random() < 0.5:
                        self.tree(q + 7.5, side * rng.uniform(9.5, 12), rng.uniform(5, 8.5))
                q += float(rng.uniform(15, 20))
            for q in np.arange(-15.0, self.end, 2.75):
                gate = (q % 17.0) < 4.2
                if not gate and self.free(q, side * 7.0, 0):
                    self.add(Billboard(path.point(q, side * 6.9), self._pick(self.hedges), 3.0, 1.3), 260)
            for q in np.arange(-20.0, self.end + 300, 20.0):
                self.wood(q, side * rng.uniform(34, 60), rng.uniform(8, 12))
                if rng.random() < 0.4:
                    at, off, tall = q + rng.uniform(-4, 4), side * rng.uniform(26, 40), rng.uniform(9, 14)
                    self.tree(at, off, tall, 500, conifer=rng.random() < 0.3)
        for k, q in enumerate(np.arange(22.0, self.end, 33.0)):
            side = -1 if k % 2 else 1
            if self.free(q, side * 6.2, 0):
                self.stand(structures.lamp_post, q, side * 5.8, 300, -side, lit)
        for q in np.arange(14.0, self.end, 12.5):
            right, forward = path.frame(q)
            if rng.random() < 0.55 and self.free(q, -4.6, 1.0):
                kind = vehicles.car if rng.random() < 0.8 else vehicles.van
                self.add(Body(Mesh(kind(rng, lit=False)), path.point(q, -4.35), -right, -forward), 300)
            if rng.random() < 0.25 and self.free(q, 4.4, 1.0):
                self.add(Body(Mesh(vehicles.car(rng, lit=False)), path.point(q, 4.45), right, forward), 300)
            if rng.random() < 0.3:
                at = q + 5
                if self.free(at, 5.6, 1.5):
                    colour = [(30, 70, 140), (200, 160, 20), (46, 50, 50)][int(rng.integers(3))]
                    self.add(structures.bin_body(path.point(at, 5.6), right, forward, colour), 120)
                    d.distractors.append({"kind": "bin", "s": round(float(at), 1)})
        self.plate("shop_disc", sign_lookalikes.shop_disc(rng), 52.0, 8.0, (1.1, 1.1), 2.9)
        self.plate("parking", sign_lookalikes.parking(), 76.0, 6.0, (0.6, 0.6), 2.0)
        self.plate("poster", sign_lookalikes.poster(rng), 104.0, -8.2, (3.0, 2.1), 1.3)
        self.plate("mirror", sign_lookalikes.mirror(), 124.0, -6.2, (0.8, 0.8), 2.2)
        self.plate("sign_back", sign_lookalikes.sign_back(2), 66.0, -4.3, (0.6, 0.6), 2.1)
        self.plate("sign_back", sign_lookalikes.sign_back(28), 158.0, -4.4, (0.9, 0.9), 2.0)
        self.plate("shop_disc", sign_lookalikes.shop_disc(rng), 148.0, -8.0, (1.2, 1.2), 3.0)
        self.plate("place_name", sign_lookalikes.place_name(), 8.0, 5.4, (1.0, 0.65), 1.3)
        for q in np.arange(210, self.end, 70):
            picture: Callable[[], list[Patch]] = (
                sign_lookalikes.parking if rng.random() < 0.5 else sign_lookalikes.mirror
            )
            self.plate(picture.__name__, picture(), float(q), -6.2, (0.7, 0.7), 2.1)

    def grass(self) -> None:
        """Add tufts along the verge, which are painted when near."""
        rng, path = self.rng, self.drive.path
        low, high = (7.3, 9.0) if self.drive.scenario.town else (4.1, 9.5)
        for q in np.arange(-5.0, self.last + 60, 0.55):
            for side in (-1, 1):
                if rng.random() < 0.75:
                    spread = low + (high - low) * rng.random() ** 1.5
                    tall = float(rng.uniform(0.16, 0.34) + 0.045 * (spread - low))
                    place = path.point(float(q + rng.uniform(-0.3, 0.3)), side * spread)
                    self.add(Billboard(place, self._pick(self.tufts), tall * 1.6, tall, shades=False), 42)


def build(scenario: Scenario, seconds: float, rng: np.random.Generator) -> Drive:
    """Build a drive.

    Args:
        scenario: Its kind.
        seconds: Its length.
        rng: Source of everything that the scenario does not fix.

    Returns:
        The drive.
    """
    last = scenario.speed * (seconds + 0.5)
    path = RoadPath.winding(last + 900, scenario.turn, rng)
    drive = Drive(scenario, WEATHERS[scenario.weather], TOWN if scenario.town else COUNTRY, path)
    drive.bumps = [b for b in scenario.bumps if b[0] < seconds]
    for t in np.arange(15.0, seconds, 6.0):
        drive.bumps.append((float(t + rng.uniform(0, 5)), float(rng.uniform(0.3, 1.0))))
    if scenario.bridge is not None and scenario.bridge < seconds + 15:
        begin = drive.distance(scenario.bridge)
        drive.bridge = (begin, begin + 11.0)
    builder = _Builder(drive, rng, last)
    builder.posts()
    builder.traffic()
    (builder.town if scenario.town else builder.country)()
    builder.grass()
    if drive.bridge is not None:
        right, forward = path.frame(drive.bridge[0])
        half = 6.6 if scenario.town else 7.5
        for thing in structures.bridge(rng, path.point(drive.bridge[0], 0.0), right, forward, 11.0, 4.9, half):
            builder.add(thing, 500)
    return drive
