"""All figures of the paper, each with its place in the paper.

Yuan, Xiong and Wang, IEEE Transactions on Intelligent Transportation Systems 18(7), 2017, pages 1918 to 1929,
doi 10.1109/TITS.2016.2614548. All are of its own videos, which are not public. Its "false positive per frame" (Table I:
0.0324, 0.0083, 0.00528) is left out: those are the false detections over the frames in percent, not as a share.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import floor


@dataclass(frozen=True, slots=True)
class System:
    """One column of Tables I and II.

    Attributes:
        name: name in the paper.
        detected: number of physical signs with at least one detection, of ``SIGNS`` (Table I).
        false: number of false detections (Table I).
        detection_s: average time per frame, s (Table I).
        classified: number of signs with the correct class (Table II).
        classification_s: average time per frame, s (Table II).
        platform: processor (both tables).
    """

    name: str
    detected: int
    false: int
    detection_s: float
    classified: int
    classification_s: float
    platform: str


SIGNS = 587
"""Physical signs of TS2010 (Tables I and II)."""
FRAMES = 132_400
"""Frames of TS2010, 720x576 (section IV-E)."""
SYSTEMS = (
    System("[20] colour + MSER", 546, 43, 0.189, 539, 0.0041, "CPU"),
    System("[47] deep network", 582, 11, 0.072, 581, 0.072, "GPU"),
    System("the paper", 577, 7, 0.076, 574, 0.052, "CPU"),
)
"""The columns of both tables; a GTX TITAN X for the network, an i5-3470 for the others (section IV-E)."""
EQ7_KF, EQ7_ONLINE = 0.1972, 0.1175
"""Mean of Eq. 7 with the Kalman filter alone and with the online detector, TS2010 (section IV-D2, with Fig. 11)."""

WHERE_EQ7 = "section IV-D2, Fig. 11"


def truncated_percent(part: int, whole: int) -> str:
    """A rate as in both tables: in percent, truncated to two decimals."""
    return f"{floor(1e4 * part / whole) / 100:.2f} %"
