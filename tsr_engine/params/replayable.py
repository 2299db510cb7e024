"""The parameters that a replay can change: those of the steps after detection."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from tsr_engine.errors import UsageError
from tsr_engine.params import Params

FIXED = (
    "detector.",
    "tracking.use_camera_shift",
    "tracking.shift_scale",
    # The stored shifts were measured with this focus.
    "tracking.foe_x",
    "tracking.foe_y",
)
"""Parameters of steps that a replay does not repeat; a name that ends in a dot means its whole section."""

VALUES_IN_OLD_RUNS: Mapping[str, float | bool | str | None] = MappingProxyType(
    {
        "detector.beyond_edge": 0.08,
        "detector.refine_passes": 1,
        "tracking.noise_score": 0.0,
        "tracking.result_noise": 1.0,
        "tracking.level_frames": 0,
        "tracking.open_edges": False,
        "tracking.sure_score": None,
        "gate.position_offset": 0.0,
        "pipeline.relocalise_after": None,
        "pipeline.rescore_windows": False,
        "pipeline.inflate_rejected_noise": False,
        "pipeline.search_sigmas": None,
        "pipeline.search_size_noise": None,
        "pipeline.reader": "classifier",
        "online.learn_undetected": True,
    }
)
"""Values in force in runs whose evidence is older than these parameters."""


def is_replayable(name: str) -> bool:
    """Whether a replay may change a parameter; the name includes the section, as in ``gate.tau``."""
    return not any(name.startswith(fixed) if fixed.endswith(".") else name == fixed for fixed in FIXED)


def refuse_missing_focus(before: Params, now: Params) -> None:
    """Refuse a replay with the motion model ``looming`` of a run with another one, unless the focus is set.

    A new run would estimate the focus from the beginning of its drive, which a replay does not have.

    Raises:
        UsageError: the focus is not set.
    """
    if now.tracking.motion == "looming" != before.tracking.motion and now.tracking.coast_foe_y is None:
        raise UsageError(
            "The motion model looming needs the camera's focus of expansion, which the run has not estimated. Set "
            "coast_foe_y to the value that `tsr calibrate` finds in the video, or track the video again."
        )


def changed_parameters(before: Params, now: Params) -> list[str]:
    """Full names, such as ``gate.tau``, of the parameters that differ."""
    old, new = before.model_dump(), now.model_dump()
    return [f"{section}.{leaf}" for section, leaf in Params.names() if old[section][leaf] != new[section][leaf]]
