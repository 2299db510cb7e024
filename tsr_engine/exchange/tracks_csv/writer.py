"""Writes tracks as rows."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tsr_engine.evidence.reader import RESULT_HEADER
from tsr_engine.exchange.attributes import attributes_as_json, lost_attributes
from tsr_engine.exchange.dataset import Dataset, Skipped
from tsr_engine.exchange.formats import ExportOptions, Format, Switch, Written
from tsr_engine.exchange.frame_origin import FIRST_FRAME_SWITCH
from tsr_engine.exchange.frame_rows import FrameRows, rows_by_frame
from tsr_engine.exchange.linking import LINK_SWITCH
from tsr_engine.exchange.notes import notes_to_text
from tsr_engine.exchange.output_sink import OutputSink
from tsr_engine.exchange.sidecar import ATTRIBUTES_COLUMN
from tsr_engine.exchange.split import names_of_subsets, subset_of
from tsr_engine.exchange.track_numbers import track_numbers
from tsr_engine.exchange.tracks_csv.reader import read_tracks_csv, sniff_tracks_csv
from tsr_engine.exchange.video_matching import TASK_SWITCH
from tsr_engine.exchange.video_names import video_names
from tsr_engine.track_table import NO_CLASS

if TYPE_CHECKING:
    from _csv import Writer


_RESULT_COLUMNS = RESULT_HEADER.split(",")
_GROUND_TRUTH_COLUMNS = ("frame", "track_id", "x1", "y1", "x2", "y2", "class_id", "visibility", "ignore")
_EXTRA_COLUMNS = ("label", "uid", "key", "occluded", "ignore", "state", "note", ATTRIBUTES_COLUMN)
_FORMULA = re.compile(r"[=+\-@\t\r]")


def file_names(dataset: Dataset, options: ExportOptions, suffix: str) -> list[list[tuple[str, str]]]:
    """The files of each video: subset (``default`` without split) and name."""
    return [
        [
            (subset, (f"{subset}/" if options.split else "") + name + suffix)
            for subset in names_of_subsets(options.split)
        ]
        for name in video_names(dataset.videos)
    ]


def _write(dataset: Dataset, out: OutputSink, options: ExportOptions) -> Written:
    layout = options.switches.get("layout", "full")
    quote_formulas = options.switches.get("formulas", "plain") == "quoted"
    header = {
        "full": [*_RESULT_COLUMNS, *_EXTRA_COLUMNS],
        "results": _RESULT_COLUMNS,
        "truth": list(_GROUND_TRUTH_COLUMNS),
    }[layout]
    total = sum(1 for video in dataset.videos for _ in video.tracks())
    done = 0
    names = {label.id: label.name for label in dataset.labels} | {NO_CLASS: ""}
    for video, files in zip(dataset.videos, file_names(dataset, options, ".csv"), strict=True):
        for subset, name in files:
            only = {track.uid for track in video.tracks() if subset_of(video, track.uid, options.split) == subset}
            rows = rows_by_frame(video, only=only)
            with out.text(name, errors="replace") as file:
                table = csv.writer(file, lineterminator="\n")
                table.writerow(header)
                _write_rows(table, rows, names, layout, quote_formulas)
            done += len(rows.tracks)
            options.progress(done, total)
    return _left_out(dataset, layout), {
        "origin": 0,
        "layout": layout,
        "columns": header,
        "formulas": "quoted" if quote_formulas else "plain",
    }


def _write_rows(table: Writer, rows: FrameRows, labels: Mapping[int, str], layout: str, quote_formulas: bool) -> None:
    ids = track_numbers(info.uid for info in rows.tracks)
    number = [ids[info.uid] for info in rows.tracks]
    # The short layouts are read and compared by other commands; the full one restores the whole data set.
    boxes = rows.table.boxes if layout == "full" else np.round(rows.table.boxes, 2)
    tracks_with_note: set[int] = set()
    rows_of_table = zip(rows.table.frame.tolist(), rows.table.track.tolist(), boxes.tolist(), strict=True)
    for k, (frame, track, edges) in enumerate(rows_of_table):
        info = rows.tracks[track]
        label = int(rows.table.class_id[k])
        common_cells = [frame, number[track], *edges, label]
        if layout == "truth":
            table.writerow([*common_cells, int(not rows.table.occluded[k]), int(rows.table.ignore[k])])
            continue
        score = float(rows.table.score[k])
        if layout == "results":
            # Commands that read this layout need a number, so no cell is empty.
            table.writerow([*common_cells, f"{score:.4f}" if score == score else "0.0000", info.source])
            continue
        note = "" if track in tracks_with_note else notes_to_text(info.notes)
        tracks_with_note.add(track)
        text = [labels[label], info.uid]
        cells = [_quote_formula(cell) for cell in text] if quote_formulas else text
        flags = [int(rows.table.key[k]), int(rows.table.occluded[k]), int(rows.table.ignore[k])]
        table.writerow(
            [
                *common_cells,
                f"{score:.9g}" if score == score else "",
                info.source,
                *cells,
                *flags,
                info.state,
                _quote_formula(note) if quote_formulas else note,
                attributes_as_json({**info.attributes, **rows.attributes_at(k)}),
            ]
        )


def _quote_formula(cell: str) -> str:
    """Prefix a cell that a spreadsheet would take for a formula."""
    return f"'{cell}" if _FORMULA.match(cell) or cell.startswith("'") else cell


def _left_out(dataset: Dataset, layout: str) -> list[Skipped]:
    if layout == "full":
        return []
    tracks = [track for video in dataset.videos for track in video.tracks()]
    notes = sum(len(track.notes) for track in tracks)
    ignored = sum(int(track.ignore.sum()) for track in tracks if track.ignore is not None)
    scores = sum(int(np.isfinite(track.score).sum()) for track in tracks)
    found = [(notes, "notes", "This layout has no column for them.")]
    if layout == "results":
        found.append((ignored, "marks to ignore", "This layout has no column for them; choose layout=truth or full."))
    else:
        found.append((scores, "scores", "This layout has no column for them; choose layout=results or full."))
    left = [Skipped(f"{count} {what}", reason) for count, what, reason in found if count]
    return left + lost_attributes(dataset, all_of_them=True, title=f"The layout {layout}")


FORMAT = Format(
    name="tracks-csv",
    title="Tracks as CSV",
    summary="One row per box: results of tsr track or of another tracker, or ground truth.",
    write=_write,
    read=read_tracks_csv,
    sniff=sniff_tracks_csv,
    export_switches=(
        Switch("layout", ("full", "results", "truth"), "All columns, those of tsr track, or those of ground truth."),
        Switch("formulas", ("plain", "quoted"), "Quote cells that a spreadsheet would take for formulas."),
    ),
    import_switches=(FIRST_FRAME_SWITCH, TASK_SWITCH, LINK_SWITCH),
    allows_pictures=False,
    docs="tracks-csv.md",
)
