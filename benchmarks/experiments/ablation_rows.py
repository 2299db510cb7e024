"""The rows of the ablation: departures of ``default`` from ``paper``, and other values that were considered."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tsr_engine.params import PRESETS, Params


@dataclass(frozen=True, slots=True)
class Departure:
    """A group of parameters in which ``default`` departs from ``paper``.

    Attributes:
        title: text of the row, which describes the paper's way.
        leaves: names of the parameters.
    """

    title: str
    leaves: tuple[str, ...]


DEPARTURES = (
    Departure("boxes without inset", ("inset_width", "inset_height", "inset_rise")),
    Departure("the paper's motion model", ("motion",)),
    Departure("detection noise 0.07 of the centre, 0.14 of the size", ("noise_centre", "noise_size")),
    Departure("noise of a detection independent of its score", ("noise_score",)),
    Departure("filter's state as result", ("result_noise",)),
    Departure("cut-off edges measured", ("open_edges",)),
    Departure("only sure detections start tracks", ("birth_score",)),
    Departure("two sure detections do not confirm a track", ("sure_score",)),
    Departure("no camera shift", ("use_camera_shift",)),
    Departure("lasting tilt of the camera allowed", ("level_frames",)),
    Departure("search at one scale", ("search_scales",)),
    Departure("no distance penalty in the search", ("search_penalty",)),
    Departure("search without sub-pixel steps", ("search_subpixel",)),
    Departure("no background windows learned", ("background_negatives",)),
    Departure("rejected predictions learned as background", ("learn_rejected",)),
    Departure("hash of the plain mean picture", ("hash_memory",)),
    Departure("gate's distance in pixels", ("position_unit",)),
    Departure("gate's distance includes camera shift", ("position_camera",)),
    Departure("online window replaces a rejected detection", ("rejected_measurement",)),
    Departure("no relocalisation of accepted predictions", ("relocalise_after",)),
    Departure("no window rescoring", ("rescore_windows",)),
    Departure("windows far from the prediction accepted", ("search_sigmas",)),
    Departure("predictions without a detection learned as the sign", ("learn_undetected",)),
    Departure("fusion by Eq. 5 without clamp", ("fusion_mode",)),
    Departure("classifier without network", ("reader",)),
)
"""Departures of ``default`` from ``paper``, row by row; a test checks that the list is complete."""

IN_QUESTION: Mapping[str, tuple[tuple[str, object], ...]] = {
    "no online detector": (("use_online", False),),
    "search window's size weighted like its position": (("search_size_noise", None),),
    "rejected windows without extra noise": (("inflate_rejected_noise", False),),
    "motion model `constant_velocity`": (("motion", "constant_velocity"),),
    "tau 10": (("tau", 10.0),),
    "tau 19": (("tau", 19.0),),
    "tau 25": (("tau", 25.0),),
    "gate by appearance: offset 2, tau 90": (("position_offset", 2.0), ("tau", 90.0)),
}
"""Values of neither preset that were considered for ``default``."""

ON_CLIPS = (
    "default",
    "boxes without inset",
    "the paper's motion model",
    "detection noise 0.07 of the centre, 0.14 of the size",
    "noise of a detection independent of its score",
    "filter's state as result",
    "cut-off edges measured",
    "only sure detections start tracks",
    "two sure detections do not confirm a track",
    "no camera shift",
    "lasting tilt of the camera allowed",
    "gate's distance in pixels",
    "no relocalisation of accepted predictions",
    "gate by appearance: offset 2, tau 90",
    "no online detector",
    "paper",
)
"""Rows that also run on the real clips, whose pictures are three times as large."""


def configurations() -> dict[str, Params]:
    """All rows: ``default``, each departure reverted, the considered values, ``paper``."""
    default = Params.preset("default")
    rows = {"default": default}
    rows |= {d.title: default.with_settings([(leaf, PRESETS["paper"][leaf]) for leaf in d.leaves]) for d in DEPARTURES}
    rows |= {title: default.with_settings(settings) for title, settings in IN_QUESTION.items()}
    return rows | {"paper": Params.preset("paper")}
