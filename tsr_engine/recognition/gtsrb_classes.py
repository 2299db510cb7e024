"""The 43 sign classes of the GTSRB benchmark (Stallkamp et al. 2012): names, category and shape.

The class numbers are those of the benchmark and of GTSDB. The categories are those of the GTSDB competition (Houben et
al. 2013).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Category = Literal["prohibitory", "mandatory", "danger", "other"]
Shape = Literal["circle", "triangle", "inverted triangle", "octagon", "diamond"]


@dataclass(frozen=True, slots=True)
class SignClass:
    """One class of traffic signs."""

    id: int
    """The benchmark's class number, 0..42."""
    name: str
    """Full English name."""
    short: str
    """At most 12 characters, for labels in pictures and narrow tables."""
    category: Category
    shape: Shape


def _prohibitory(id: int, name: str, short: str) -> SignClass:
    return SignClass(id, name, short, "prohibitory", "circle")


def _danger(id: int, name: str, short: str) -> SignClass:
    return SignClass(id, name, short, "danger", "triangle")


def _mandatory(id: int, name: str, short: str) -> SignClass:
    return SignClass(id, name, short, "mandatory", "circle")


SIGN_CLASSES: tuple[SignClass, ...] = (
    _prohibitory(0, "speed limit 20 km/h", "20"),
    _prohibitory(1, "speed limit 30 km/h", "30"),
    _prohibitory(2, "speed limit 50 km/h", "50"),
    _prohibitory(3, "speed limit 60 km/h", "60"),
    _prohibitory(4, "speed limit 70 km/h", "70"),
    _prohibitory(5, "speed limit 80 km/h", "80"),
    SignClass(6, "end of speed limit 80 km/h", "end 80", "other", "circle"),
    _prohibitory(7, "speed limit 100 km/h", "100"),
    _prohibitory(8, "speed limit 120 km/h", "120"),
    _prohibitory(9, "no overtaking", "no overtake"),
    _prohibitory(10, "no overtaking by lorries", "no ovtk HGV"),
    _danger(11, "priority at the next junction", "priority jct"),
    SignClass(12, "priority road", "priority rd", "other", "diamond"),
    SignClass(13, "give way", "give way", "other", "inverted triangle"),
    SignClass(14, "stop", "stop", "other", "octagon"),
    _prohibitory(15, "no vehicles", "no vehicles"),
    _prohibitory(16, "no lorries", "no lorries"),
    SignClass(17, "no entry", "no entry", "other", "circle"),
    _danger(18, "general danger", "danger"),
    _danger(19, "curve to the left", "curve left"),
    _danger(20, "curve to the right", "curve right"),
    _danger(21, "double curve, first to the left", "double curve"),
    _danger(22, "uneven road", "uneven road"),
    _danger(23, "slippery road", "slippery"),
    _danger(24, "road narrows on the right", "narrows"),
    _danger(25, "road works", "road works"),
    _danger(26, "traffic lights ahead", "lights ahead"),
    _danger(27, "pedestrians", "pedestrians"),
    _danger(28, "children", "children"),
    _danger(29, "cyclists crossing", "cyclists"),
    _danger(30, "ice or snow", "ice or snow"),
    _danger(31, "wild animals", "wild animals"),
    SignClass(32, "end of all restrictions", "end all", "other", "circle"),
    _mandatory(33, "turn right ahead", "turn right"),
    _mandatory(34, "turn left ahead", "turn left"),
    _mandatory(35, "straight ahead only", "straight"),
    _mandatory(36, "straight ahead or right", "str or right"),
    _mandatory(37, "straight ahead or left", "str or left"),
    _mandatory(38, "keep right", "keep right"),
    _mandatory(39, "keep left", "keep left"),
    _mandatory(40, "roundabout", "roundabout"),
    SignClass(41, "end of no overtaking", "end no ovtk", "other", "circle"),
    SignClass(42, "end of no overtaking by lorries", "end no HGV", "other", "circle"),
)
"""All classes; the index is the class number."""

CLASS_COUNT = len(SIGN_CLASSES)
CLASS_NAMES = tuple(sign.name for sign in SIGN_CLASSES)
"""Display name of each class."""

CLASSES_AFTER_HALF_TURN: tuple[tuple[int, int], ...] = ((12, 12), (15, 15), (17, 17), (32, 32))
"""``(class, class after a turn by 180 degrees)`` of the signs that stay valid."""


def class_name(class_id: int) -> str:
    """Full name of a class.

    Raises:
        ValueError: the number is not in 0..42.
    """
    if not 0 <= class_id < CLASS_COUNT:
        raise ValueError(f"class_id must be in 0..{CLASS_COUNT - 1}. Got {class_id} instead.")
    return SIGN_CLASSES[class_id].name
