"""Motion models by name."""

from __future__ import annotations

from tsr_engine.params.tracking import TrackingParams
from tsr_engine.protocols import MotionModel
from tsr_engine.tracking.measurement_noise import MeasurementNoise
from tsr_engine.tracking.motion_constant_velocity import ConstantVelocityMotion
from tsr_engine.tracking.motion_looming import LoomingMotion, LoomingNoise
from tsr_engine.tracking.motion_paper import PaperMotion


def make_motion(params: TrackingParams) -> MotionModel:
    """The motion model that ``params.motion`` names, with its parameters."""
    noise = MeasurementNoise(params.noise_centre, params.noise_size)
    if params.motion == "paper":
        return PaperMotion(noise, params.displacement_window, params.paper_process)
    if params.motion == "constant_velocity":
        return ConstantVelocityMotion(noise, params.velocity_process)
    process = LoomingNoise(
        growth_start=params.growth_start,
        growth_spread=params.growth_spread,
        growth=params.growth_process,
        scale=params.scale_process,
        aspect=params.aspect_process,
        centre=params.centre_process,
        centre_px=params.centre_process_px,
        drift_px=params.drift_process,
        drift_decay=params.drift_decay,
        foe_spread=params.foe_spread,
    )
    return LoomingMotion(noise, process, (params.foe_x, params.foe_y))
