"""`tsr track`: one video in; result rows, evidence and an annotated video out."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tsr_engine.cli.common import (
    JsonOption,
    ModelsOption,
    OnnxLayoutOption,
    OnnxOption,
    OnnxSizeOption,
    PresetOption,
    SetOption,
    frame_range,
    make_network,
    make_params,
    out_console,
    print_json,
    say,
)
from tsr_engine.io.video_kinds import KIND_NAMES
from tsr_engine.plural import plural

if TYPE_CHECKING:
    from rich.table import Table

    from tsr_engine.pipeline import TrackSummary
    from tsr_engine.runs.track_video import RunReport


def track(
    video: Annotated[Path, typer.Argument(metavar="VIDEO", help=f"A video file: {KIND_NAMES}.")],
    csv: Annotated[
        Path | None, typer.Option("--csv", metavar="OUT", help="Write one row for each track and frame.")
    ] = None,
    evidence: Annotated[
        Path | None,
        typer.Option(
            "--evidence", metavar="DIR", help="Folder for all evidence; after a kill the same command continues."
        ),
    ] = None,
    annotated: Annotated[
        Path | None, typer.Option("--video", metavar="OUT.mp4", help="Write the video with the results drawn on it.")
    ] = None,
    preset: PresetOption = "default",
    settings: SetOption = [],  # noqa: B006 - typer copies it
    models: ModelsOption = None,
    onnx: OnnxOption = None,
    onnx_size: OnnxSizeOption = None,
    onnx_layout: OnnxLayoutOption = None,
    frames: Annotated[
        str | None, typer.Option("--frames", metavar="A:B", help="Only frames A to B-1, counted from 0.")
    ] = None,
    restart: Annotated[bool, typer.Option("--restart", help="Start over if --evidence already holds a run.")] = False,
    cores: Annotated[
        int | None,
        typer.Option(
            "--cores", min=1, max=64, metavar="N", help="Processes that detect frames; unset: one for each core."
        ),
    ] = None,
    timing: Annotated[bool, typer.Option("--timing", help="Print the time of each stage.")] = False,
    json: JsonOption = False,
) -> None:
    """Track and classify the traffic signs of one video.

    Without an output option the command prints a table of the tracks. The rows of --csv are
    frame,track_id,x1,y1,x2,y2,class_id,score,source: frames from 0, pixel edges, confirmed tracks from their first
    frame on, the class fused over the whole track, source in detected|predicted|relocalised.

    \b
    Examples:
      tsr track drive.mp4
      tsr track drive.mp4 --csv rows.csv --video seen.mp4
      tsr track drive.mp4 --evidence run1 --set tau=20 --set motion=paper
      tsr track drive.mp4 --preset paper --frames 100:400 --timing
      tsr track drive.mp4 --onnx signs.onnx --onnx-size 640x640 --onnx-layout v8
    """
    start, stop = frame_range(frames)
    params = make_params(preset, settings)
    network = make_network(onnx, onnx_size, onnx_layout)
    from tsr_engine.cli.interrupt import leave_interrupted, stop_on_interrupt
    from tsr_engine.cli.progress import progress_bar, rate_text
    from tsr_engine.io.cores import usable_cores
    from tsr_engine.io.video_probe import check_file
    from tsr_engine.pipeline import load_components
    from tsr_engine.runs.track_video import Progress, RunRequest, track_video

    check_file(video)
    components = load_components(params, models, network)
    request = RunRequest(video, params, evidence, csv, annotated, start, stop, restart, cores=cores or usable_cores())
    kept = " and ".join(str(path) for path in (csv, evidence, annotated) if path is not None)
    resume_hint = " Run the same command again to go on." if evidence is not None else ""
    done = 0
    with stop_on_interrupt() as stopped, progress_bar("tracking", "frames") as show:

        def show_rate(progress: Progress) -> None:
            nonlocal done
            done = progress.done
            show(progress.done, progress.total, rate_text(progress.rate))

        try:
            report = track_video(
                request,
                components,
                progress=show_rate,
                focus_progress=lambda looked, most: show(looked, most, "looked at for where the camera points"),
                stop=stopped,
            )
        except KeyboardInterrupt:  # a second Ctrl-C, within a frame
            if not (done and kept):
                leave_interrupted("There are no results.")
            leave_interrupted(f"Results up to the last whole frames are kept in {kept}.{resume_hint}")
    for warning in report.warnings:
        say(f"warning: {warning}")
    if json:
        from tsr_engine.runs.report_json import report_as_json

        print_json(report_as_json(report, request))
    else:
        print_report(report, timing)
    if report.interrupted:
        if not report.frames:
            leave_interrupted("Stopped before the first frame: there are no results yet.")
        last = report.first_frame + report.frames - 1
        where = f"kept in {kept}" if kept else "shown above"
        leave_interrupted(f"Results up to frame {last} are {where}.{resume_hint}")


def print_report(report: RunReport, timing: bool) -> None:
    """Print the tracks as a table, and the stages if ``timing``."""
    console = out_console()
    if report.computed:
        resumed = "" if report.resumed_at is None else f", resumed at frame {report.resumed_at}"
        how = f"{report.computed / max(report.seconds, 1e-9):.1f} frames/s{resumed}"
    else:
        how = "all of it from the evidence"
    console.print(
        f"{report.video}: {plural(report.frames, 'frame')} of {report.width}x{report.height}, "
        f"{plural(len(report.tracks), 'sign')}, {how}",
        soft_wrap=True,
    )
    if report.focus is not None:
        console.print(
            f"The camera's focus of expansion lies at {report.focus.y:.3f} of the picture's height (estimated from "
            f"{report.focus.frames} frames in {report.focus_seconds:.1f} s).",
            soft_wrap=True,
        )
    if report.tracks:
        console.print(track_table(report.tracks, report.class_names))
    if timing:
        console.print(stage_table(report))


def track_table(tracks: Sequence[TrackSummary], names: Sequence[str]) -> Table:
    """A table with one row per track; ``names`` are class names."""
    from rich.table import Table

    from tsr_engine.runs.report_json import class_name
    from tsr_engine.track_table import SOURCES

    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in ("track", "class", "sign", "frames", *SOURCES, "largest px", "vote share"):
        table.add_column(name, justify="left" if name == "sign" else "right")
    for t in tracks:
        table.add_row(
            str(t.track_id),
            "" if t.class_id < 0 else str(t.class_id),
            class_name(t.class_id, names),
            f"{t.first_frame}-{t.last_frame}",
            *(str(t.frames[source]) for source in SOURCES),
            f"{t.largest_side:.0f}",
            f"{100 * t.share:.0f} %",
        )
    return table


def stage_table(report: RunReport) -> Table:
    """A table of the stages: median and 95th percentile per frame, ms."""
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("stage")
    for name in ("frames", "median ms", "p95 ms"):
        table.add_column(name, justify="right")
    for stage, count, median, p95 in report.stage_table():
        table.add_row(stage, str(count), f"{median:.2f}", f"{p95:.2f}")
    return table
