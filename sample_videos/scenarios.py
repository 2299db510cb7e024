"""The kinds of drive, and the times of their stresses."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Scenario:
    """One kind of drive.

    Attributes:
        name: Its name.
        weather: Name of its light and air.
        town: Houses and pavements instead of fields.
        speed: Metres per second.
        shake: 1 is a good country road.
        bridge: Second at which the car passes below a bridge, or None.
        bumps: Seconds and strengths of jolts.
        posts: Classes on the first poles, from the top down, and the side: 1 right, -1 left.
        hidden: Indices of the poles with a bush (country) or a parked van (town) before them.
        met: Indices of the poles that a lorry passes as we approach (left side).
        gap: Metres between poles.
        turn: Usual turn of a bend, radians.
    """

    name: str
    weather: str
    town: bool
    speed: float
    shake: float
    bridge: float | None
    bumps: tuple[tuple[float, float], ...]
    posts: tuple[tuple[tuple[int, ...], int], ...]
    hidden: tuple[int, ...]
    met: tuple[int, ...]
    gap: float
    turn: float


SCENARIOS: dict[str, Scenario] = {
    s.name: s
    for s in (
        Scenario(
            "country_road", weather="day", town=False, speed=21.0, shake=1.0, bridge=None, gap=40.0, turn=0.30,
            bumps=((7.3, 0.35),), hidden=(4,), met=(3,),
            posts=(((12,), 1), ((20,), 1), ((4, 9), 1), ((9,), -1), ((31,), 1), ((7,), 1), ((41,), 1)),
        ),
        Scenario(
            "low_sun", weather="low_sun", town=True, speed=13.5, shake=1.7, bridge=6.6, gap=28.0, turn=0.10,
            bumps=((3.1, 0.7), (8.6, 1.0)), hidden=(2,), met=(),
            posts=(((28, 1), 1), ((11,), 1), ((13,), 1), ((2,), -1), ((38,), 1), ((25,), 1)),
        ),
        Scenario(
            "town_dusk", weather="dusk", town=True, speed=12.5, shake=1.2, bridge=None, gap=30.0, turn=0.16,
            bumps=((5.0, 0.6),), hidden=(3,), met=(1,),
            posts=(((2,), 1), ((17,), -1), ((14,), 1), ((27,), 1), ((33,), 1)),
        ),
        Scenario(
            "overcast_road", weather="overcast", town=False, speed=19.0, shake=1.4, bridge=9.0, gap=42.0, turn=0.25,
            bumps=((4.0, 0.5), (11.0, 0.9)), hidden=(1,), met=(3,),
            posts=(((24,), 1), ((3, 10), 1), ((23,), 1), ((42,), -1), ((32,), 1)),
        ),
    )
}  # fmt: skip
"""The kinds of drive by name."""
