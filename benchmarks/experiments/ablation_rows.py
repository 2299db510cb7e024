"""The rows of the ablation: departures of ``default`` from ``paper``, and other values that were considered."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tsr_engine.params import PRESETS, Params

__all__ = ["DEPARTURES", "IN_QUESTION", "ON_CLIPS", "Departure", "configurations", "departing"]


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
    Departure("boxes as the training scenes draw them", ("inset_width", "inset_height", "inset_rise")),
    Departure("motion as in the paper", ("motion",)),
    Departure("detections' noise 0.07 of the centre, 0.14 of the size", ("noise_centre", "noise_size")),
    Departure("a uncertain detection as exact as a sure one", ("noise_score",)),
    Departure("the result is the filter's state", ("result_noise",)),
    Departure("edges that the picture cuts off measured", ("open_edges",)),
    Departure("only sure sights start tracks", ("birth_score",)),
    Departure("two sure sights confirm no track", ("sure_score",)),
    Departure("no camera shift", ("use_camera_shift",)),
    Departure("a camera that may tilt for long", ("level_frames",)),
    Departure("online windows of one size", ("search_scales",)),
    Departure("no loss for distance in the search", ("search_penalty",)),
    Departure("whole pixels in the search", ("search_subpixel",)),
    Departure("no background windows learned", ("background_negatives",)),
    Departure("rejected predictions learned as background", ("learn_rejected",)),
    Departure("plain mean picture for the hash", ("hash_memory",)),
    Departure("gate's distance in pixels", ("position_unit",)),
    Departure("gate's distance with the camera's shift", ("position_camera",)),
    Departure("rejected: the online window replaces the detection", ("rejected_measurement",)),
    Departure("without a detection the gate alone decides", ("relocalise_after",)),
    Departure("search windows not rescored", ("rescore_windows",)),
    Departure("windows far from the prediction taken", ("search_sigmas",)),
    Departure("predictions without a detection learned as the sign", ("learn_undetected",)),
    Departure("fusion by Eq. 5 without a clamp", ("fusion_mode",)),
    Departure("the classifier reads alone", ("reader",)),
)
"""Departures of ``default`` from ``paper``, row by row; a test checks that the list is complete."""

IN_QUESTION: Mapping[str, tuple[tuple[str, object], ...]] = {
    "no online detector": (("use_online", False),),
    "search window's size counts as its place does": (("search_size_noise", None),),
    "a window that window rescoring refuses counts as any": (("inflate_rejected_noise", False),),
    "motion constant_velocity": (("motion", "constant_velocity"),),
    "tau 10": (("tau", 10.0),),
    "tau 19": (("tau", 19.0),),
    "tau 25": (("tau", 25.0),),
    "gate by look: offset 2, tau 90": (("position_offset", 2.0), ("tau", 90.0)),
}
"""Values of neither preset that were considered for ``default``."""

ON_CLIPS = (
    "default",
    "boxes as the training scenes draw them",
    "motion as in the paper",
    "detections' noise 0.07 of the centre, 0.14 of the size",
    "a uncertain detection as exact as a sure one",
    "the result is the filter's state",
    "edges that the picture cuts off measured",
    "only sure sights start tracks",
    "two sure sights confirm no track",
    "no camera shift",
    "a camera that may tilt for long",
    "gate's distance in pixels",
    "without a detection the gate alone decides",
    "gate by look: offset 2, tau 90",
    "no online detector",
    "paper",
)
"""Rows that also run on the real clips, whose pictures are three times as large."""


def departing() -> frozenset[str]:
    """Names of all parameters in which the two presets differ."""
    ours, theirs = Params.preset("default").model_dump(), Params.preset("paper").model_dump()
    return frozenset(leaf for section, leaf in Params.names() if ours[section][leaf] != theirs[section][leaf])


def configurations() -> dict[str, Params]:
    """All rows: ``default``, each departure reverted, the considered values, ``paper``."""
    default = Params.preset("default")
    rows = {"default": default}
    rows |= {d.title: default.with_settings([(leaf, PRESETS["paper"][leaf]) for leaf in d.leaves]) for d in DEPARTURES}
    rows |= {title: default.with_settings(settings) for title, settings in IN_QUESTION.items()}
    return rows | {"paper": Params.preset("paper")}
