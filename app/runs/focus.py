"""The camera's focus of expansion of a run, for its summary."""

from __future__ import annotations

from tsr_engine.json_shapes import JsonObject
from tsr_engine.params import Params


def focus_of(params: Params, *, named: bool) -> JsonObject | None:
    """``summary.focus`` of a run: the point of the picture from which signs that are not detected move away.

    Args:
        params: parameters of the run, with the focus estimated from its video.
        named: whether a person set the focus.

    Returns:
        ``x`` and ``y``, shares of the picture, and ``named``. None for motion models without a focus, and if it could
        not be estimated.
    """
    tracking = params.tracking
    if tracking.motion != "looming" or tracking.coast_foe_y is None:
        return None
    return {"x": tracking.foe_x, "y": tracking.coast_foe_y, "named": named}
