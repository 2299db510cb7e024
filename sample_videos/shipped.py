"""The clips that come with the package, and how they were made.

`python -m sample_videos.shipped [NAME...]` makes them again.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from sample_videos.generate import SamplePaths

CLIPS = Path(__file__).resolve().parent / "clips"
"""Folder of the clips."""


class ShippedClip(NamedTuple):
    """One shipped clip: the video and its exact ground truth.

    Attributes:
        video: MP4 file, H.264, constant rate.
        truth: CSV `frame,track_id,x1,y1,x2,y2,class_id,visibility,ignore`; a JSON of the same stem holds seed, camera,
            signs and events.
    """

    video: Path
    truth: Path


class Recipe(NamedTuple):
    """How a shipped clip was made.

    Attributes:
        scenario: Kind of drive, and stem of the files.
        seed: Seed.
        seconds: Length.
        size: Width and height.
        crf: Constant rate factor.
    """

    scenario: str
    seed: int
    seconds: float
    size: tuple[int, int]
    crf: int


RECIPES: tuple[Recipe, ...] = (
    Recipe("country_road", 3, 12.0, (960, 540), 30),
    Recipe("low_sun", 5, 12.0, (960, 540), 28),
)
"""How the clips were made."""

SHIPPED: tuple[ShippedClip, ...] = tuple(
    ShippedClip(CLIPS / f"{recipe.scenario}.mp4", CLIPS / f"{recipe.scenario}.csv") for recipe in RECIPES
)
"""The clips."""


def make(recipe: Recipe, folder: Path = CLIPS) -> SamplePaths:
    """Make a shipped clip again."""
    from sample_videos.generate import generate

    return generate(
        folder, recipe.seconds, recipe.seed, recipe.size, scenario=recipe.scenario, name=recipe.scenario, crf=recipe.crf
    )


if __name__ == "__main__":
    for chosen in RECIPES:
        if not sys.argv[1:] or chosen.scenario in sys.argv[1:]:
            print(make(chosen).video)
