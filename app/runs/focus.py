"""The camera's focus of expansion of a run, for its summary."""

from __future__ import annotations

from tsr_engine.json_shapes import JsonObject
from tsr_engine.params import Params

__all__ = ["focus_of"]


def focus_of(params: Params, *, named: bool) -> JsonObject | None:
    """Where undetected signs move away from in the picture; ``summary.focus`` of a run.

    Args:
        params: of the run, with what its drive told.
        named: whether a person named the focus.

    Returns:
        ``x`` and ``y``, shares of the picture, and ``named``. None for motion models without one, and where the drive
        did not tell it.
    """
    tracking = params.tracking
    if tracking.motion != "looming" or tracking.coast_foe_y is None:
        return None
    return {"x": tracking.foe_x, "y": tracking.coast_foe_y, "named": named}
