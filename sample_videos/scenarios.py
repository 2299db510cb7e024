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
            "country_road",
            "day",
            False,
            21.0,
            1.0,
            None,
            ((7.3, 0.35),),
            (((12,), 1), ((20,), 1), ((4, 9), 1), ((9,), -1), ((31,), 1), ((7,), 1), ((41,), 1)),
            (4,),
            (3,),
            40.0,
            0.30,
        ),
        Scenario(
            "low_sun",
            "low_sun",
            True,
            13.5,
            1.7,
            6.6,
            ((3.1, 0.7), (8.6, 1.0)),
            (((28, 1), 1), ((11,), 1), ((13,), 1), ((2,), -1), ((38,), 1), ((25,), 1)),
            (2,),
            (),
            28.0,
            0.10,
        ),
        Scenario(
            "town_dusk",
            "dusk",
            True,
            12.5,
            1.2,
            None,
            ((5.0, 0.6),),
            (((2,), 1), ((17,), -1), ((14,), 1), ((27,), 1), ((33,), 1)),
            (3,),
            (1,),
            30.0,
            0.16,
        ),
        Scenario(
            "overcast_road",
            "overcast",
            False,
            19.0,
            1.4,
            9.0,
            ((4.0, 0.5), (11.0, 0.9)),
            (((24,), 1), ((3, 10), 1), ((23,), 1), ((42,), -1), ((32,), 1)),
            (1,),
            (3,),
            42.0,
            0.25,
        ),
    )
}
"""The kinds of drive by name."""
