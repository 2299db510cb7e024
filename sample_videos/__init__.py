"""A procedural road drive with exact ground truth, and two short clips made by it.

`sample_videos.generate` renders a drive in perspective (road, fields, trees, houses, vehicles, weather, the 43 signs of
GTSRB on poles) and writes the video together with the exact box of each sign in each frame; the renderer is loaded only
when it is used. `SHIPPED` names the two clips that come with the package.
"""

from sample_videos.scenarios import SCENARIOS
from sample_videos.shipped import SHIPPED, ShippedClip

__all__ = ["SCENARIOS", "SHIPPED", "ShippedClip"]
