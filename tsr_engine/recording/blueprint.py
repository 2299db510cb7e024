"""The views that a viewer shows when it opens a recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import rerun as rr
import rerun.blueprint as rrb
from rerun.encodings import AbsoluteTimeRange

from tsr_engine.recording.layers import EVENTS, FRAME_TIMELINE, LAYERS, VIDEO, track_entity

PLOT_TITLES: Final = {
    "gate/log10_l_positive": "Gate (log10 L)",
    "gate/symmetry": "Symmetry",
    "gate/hash_distance": "Hash distance",
    "gate/position_distance": "Position distance",
    "score": "Scores",
    "svm/decision": "SVM",
    "fusion/weight": "Fusion weight",
    "votes": "Class votes",
}
"""Values with their own plot, and its title."""
_LEGEND_SHARE = 0.3
"""Share of a plot's width for its legend."""
_MAX_TRACKS = 12
"""Largest number of tracks whose lines are drawn at first; the others are hidden."""


@dataclass(frozen=True, slots=True)
class BlueprintInputs:
    """The facts that the blueprint depends on.

    Attributes:
        width: picture width, px.
        height: picture height, px.
        layers: names of the layers that the recording has.
        tracks: tracks with lines, the most informative first.
        values: (track, value) pairs that the recording has.
        focus: frames marked on the time panel, both inclusive; None: none.
        frames: first frame and the frame after the last.
    """

    width: int
    height: int
    layers: Sequence[str]
    tracks: Sequence[int]
    values: frozenset[tuple[int, str]]
    focus: tuple[int, int] | None
    frames: tuple[int, int]


def make_blueprint(inputs: BlueprintInputs) -> rrb.Blueprint:
    """Build the views: the picture with its layers, events beside it, time lines below; playback is paused."""
    picture = rrb.Spatial2DView(
        origin=VIDEO,
        name="Picture",
        visual_bounds=rrb.VisualBounds2D(x_range=(0.0, inputs.width), y_range=(0.0, inputs.height)),
        overrides={
            LAYERS[name].entity: rrb.EntityBehavior(visible=False) for name in inputs.layers if not LAYERS[name].shown
        },
    )
    log = rrb.Tabs(
        rrb.TextLogView(
            origin=EVENTS, name="Events", columns=rrb.TextLogColumns(text_log_columns=["LogLevel", "Body"])
        ),
        rrb.TextDocumentView(origin="about", name="About"),
        active_tab=0,
    )
    lower_tabs = [_states(inputs), *_plots(inputs)]
    selection: Any = None  # Any: the SDK has two types of this name
    if inputs.focus is not None:
        selection = AbsoluteTimeRange(min=inputs.focus[0], max=inputs.focus[1])
    return rrb.Blueprint(
        rrb.Vertical(
            rrb.Horizontal(picture, log, column_shares=[2, 1]),
            rrb.Tabs(*lower_tabs, active_tab=1 if len(lower_tabs) > 1 else 0),
            row_shares=[3, 2],
        ),
        rrb.TimePanel(state="collapsed", timeline=FRAME_TIMELINE, play_state="paused", time_selection=selection),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_layout=False,
        auto_views=False,
    )


def _states(inputs: BlueprintInputs) -> rrb.StateTimelineView:
    contents = [f"+ /{track_entity(track, 'state')}" for track in inputs.tracks[:_MAX_TRACKS]]
    return rrb.StateTimelineView(origin="/", contents=contents, name="Track states")


def _plots(inputs: BlueprintInputs) -> list[rrb.TimeSeriesView]:
    """One plot for each kind of value in the recording; lines end left of the legend."""
    first, stop = inputs.frames
    legend_frames = round((stop - first) * _LEGEND_SHARE / (1 - _LEGEND_SHARE))
    span = rr.TimeRange(
        start=rr.TimeRangeBoundary.absolute(seq=first), end=rr.TimeRangeBoundary.absolute(seq=stop + legend_frames)
    )
    plots = []
    for value, name in PLOT_TITLES.items():
        entities = [
            track_entity(track, value) for track in inputs.tracks[:_MAX_TRACKS] if (track, value) in inputs.values
        ]
        if entities:
            shared = ["gate/log10_tau"] if value == "gate/log10_l_positive" else []
            contents = [f"+ /{entity}" for entity in (*shared, *entities)]
            plots.append(
                rrb.TimeSeriesView(
                    origin="/",
                    contents=contents,
                    name=name,
                    axis_x=rrb.TimeAxis(view_range=span),
                    plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop),
                )
            )
    return plots
