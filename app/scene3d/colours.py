"""Colours of the scenes, and the legends that explain them. The same inks as on the page (static/css/tokens.css)."""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Colouring = Literal["class", "verdict", "source"]
COLOURS: Final[dict[Colouring, str]] = {
    "class": "Class of the track",
    "verdict": "Verdict of the gate",
    "source": "Source of the box",
}
Rgb = tuple[int, int, int]
ByteArray = NDArray[np.uint8]

_SERIES: Final[tuple[Rgb, ...]] = (
    (86, 180, 233),
    (230, 159, 0),
    (0, 185, 135),
    (240, 228, 66),
    (224, 134, 184),
    (255, 122, 69),
    (120, 150, 255),
    (190, 230, 130),
)
_OTHER: Final[Rgb] = (138, 146, 158)
_SOURCE: Final[tuple[tuple[str, Rgb], ...]] = (
    ("detected", (86, 180, 233)),
    ("predicted only", (240, 228, 66)),
    ("found again by the online detector", (230, 159, 0)),
)
_VERDICT: Final[tuple[tuple[str, Rgb], ...]] = (
    ("not judged", _OTHER),
    ("confident", (0, 185, 135)),
    ("rejected", (255, 98, 72)),
)


@dataclass(frozen=True, slots=True)
class Entry:
    """One line of a legend."""

    colour: Rgb
    text: str


@dataclass(frozen=True, slots=True)
class Paint:
    """A colour per row, and the legend."""

    rows: ByteArray
    """Shape (n, 3)."""
    legend: tuple[Entry, ...]


class _Inks:
    """Single colours with a fixed meaning."""

    selected: Final[Rgb] = (255, 255, 255)
    frame: Final[Rgb] = (255, 255, 255)
    edge: Final[Rgb] = (92, 104, 122)
    tick: Final[Rgb] = (58, 68, 84)
    tracked: Final[Rgb] = (0, 205, 150)
    other: Final[Rgb] = (255, 122, 69)
    road: Final[Rgb] = (70, 80, 96)
    camera: Final[Rgb] = (200, 210, 224)


INK: Final = _Inks()


def paint(
    by: Colouring,
    track: ArrayLike,
    class_id: ArrayLike,
    source: ArrayLike,
    verdict: ArrayLike,
    names: Mapping[int, str],
) -> Paint:
    """Colour rows.

    Args:
        by: property that the colour shows.
        track: shape (n,), index of each row's track.
        class_id: shape (t,), label of each track, -1: unknown.
        source: shape (n,), 0 detected, 1 predicted, 2 relocalised.
        verdict: shape (n,), 0 not judged, 1 confident, 2 rejected.
        names: names of the labels.
    """
    if by == "source":
        return _by_code(source, _SOURCE)
    if by == "verdict":
        return _by_code(verdict, _VERDICT)
    classes = np.asarray(class_id, np.int64)
    present, counts = np.unique(classes[classes >= 0], return_counts=True)
    order = present[np.lexsort((present, -counts))][: len(_SERIES)]
    track_colours = np.tile(np.array(_OTHER, np.uint8), (len(classes), 1))
    legend = []
    for colour, label in zip(_SERIES, order.tolist(), strict=False):
        track_colours[classes == label] = colour
        legend.append(Entry(colour, names.get(label, f"label {label}")))
    if len(present) > len(order):
        legend.append(Entry(_OTHER, f"{len(present) - len(order)} other labels"))
    if (classes < 0).any():
        legend.append(Entry(_OTHER, "not recognised"))
    rows = track_colours[np.asarray(track, np.int64)] if len(classes) else np.zeros((0, 3), np.uint8)
    return Paint(rows, tuple(legend))


def _by_code(codes: ArrayLike, names: tuple[tuple[str, Rgb], ...]) -> Paint:
    found = np.asarray(codes, np.int64)
    inks = np.array([colour for _, colour in names], np.uint8)
    present = set(np.unique(found).tolist())
    return Paint(inks[found], tuple(Entry(c, text) for i, (text, c) in enumerate(names) if i in present))


def height_colours(values: ArrayLike) -> ByteArray:
    """Map heights in [0, 1] to colours, shape (..., 3): dark blue, teal, yellow."""
    stops = np.array([(52, 76, 138), (33, 145, 140), (122, 209, 81), (253, 231, 37)], np.float64)
    v = np.clip(np.asarray(values, np.float64), 0.0, 1.0)
    return np.stack([np.interp(v, np.linspace(0, 1, 4), stops[:, i]) for i in range(3)], axis=-1).astype(np.uint8)


def linear(colours: ArrayLike) -> ByteArray:
    """Convert colours of vertices and instances to the form that viser expects.

    viser reads a single colour as sRGB, but colours per vertex or instance as linear light.

    Args:
        colours: sRGB, shape (..., 3), 0 to 255.
    """
    v = np.clip(np.asarray(colours, np.float64), 0, 255) / 255
    light = np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)
    return np.asarray(np.round(light * 255), np.uint8)


def legend_html(title: str, entries: tuple[Entry, ...], notes: tuple[str, ...] = ()) -> str:
    """Format a legend as HTML without scripts; all text is escaped."""
    rows = "".join(
        '<div style="display:flex;align-items:center;gap:8px;margin:3px 0">'
        f'<span style="flex:none;width:14px;height:10px;border-radius:2px;background:rgb{e.colour}"></span>'
        f"<span>{html.escape(e.text)}</span></div>"
        for e in entries
    )
    notes_html = "".join(f'<p style="margin:6px 0 0;opacity:.75">{html.escape(note)}</p>' for note in notes)
    return (
        '<div style="font:12px/1.4 system-ui,sans-serif;padding:2px 12px 8px">'
        f'<div style="font-weight:600;margin-bottom:4px">{html.escape(title)}</div>{rows}{notes_html}</div>'
    )
