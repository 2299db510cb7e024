"""``tsr bundle``: packs a problem into one file for other people."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from app.cli.library import HomeOption
from tsr_engine.cli.common import JsonOption, existing, frame_range, out_console, print_json, say
from tsr_engine.errors import UsageError
from tsr_engine.plural import plural


def bundle(
    run: Annotated[
        str, typer.Argument(metavar="RUN", help="A run's id, an evidence folder, or a video (its newest run).")
    ],
    out: Annotated[Path, typer.Option("--out", metavar="FILE.zip", help="The bundle.")],
    frames: Annotated[
        str | None, typer.Option("--frames", metavar="A:B", help="Frames A to B-1; unset: all of the run.")
    ] = None,
    note: Annotated[str, typer.Option("--note", metavar="TEXT", help="What is wrong, in your words.")] = "",
    tracks: Annotated[
        list[str], typer.Option("--track", metavar="KEY", help="A track with the problem, for example 7; repeatable.")
    ] = [],  # noqa: B006 - typer copies it
    expect: Annotated[
        Path | None,
        typer.Option("--expect", metavar="FILE", help="An expectation.json; unset: made from the corrections."),
    ] = None,
    max_eq7: Annotated[
        float | None, typer.Option("--max-eq7", min=0, max=0.99, help="Error that a corrected box may have.")
    ] = None,
    home: HomeOption = None,
    video: Annotated[
        Path | None, typer.Option("--video", metavar="VIDEO", help="The video; needed for a bare evidence folder.")
    ] = None,
    models: Annotated[
        Path | None,
        typer.Option("--models", metavar="DIR", help="Models of the run, if they are not the shipped ones."),
    ] = None,
    onnx: Annotated[
        Path | None,
        typer.Option("--onnx", metavar="FILE", help="The ONNX network of the run, to include; 256 MiB at most."),
    ] = None,
    recording: Annotated[
        bool, typer.Option("--recording/--no-recording", help="Include a recording for the Rerun viewer.")
    ] = True,
    json: JsonOption = False,
) -> None:
    """Pack frames of a run with clip, output, corrections and settings into one file that replays a problem.

    The file is complete or absent. `tsr replay FILE.zip` runs the engine on it again and says fixed, still broken or
    different; without expectations, unchanged or different.

    \b
    Examples:
      tsr bundle drive.mp4 --frames 400:460 --note "the 50 reads as 80" --out bug.zip
      tsr bundle 3f2a... --frames 400:460 --track m7 --out bug.zip
      tsr bundle run1 --video drive.mp4 --frames 400:460 --expect expectation.json --out bug.zip
    """
    from app.bundles.request import bundle_request, report_summary
    from app.cli.progress import step_counter
    from app.cli.run_names import as_command_error, find_sources, track_key
    from tsr_engine.bundle import make_bundle
    from tsr_engine.io.models import read_manifest

    first, stop = frame_range(frames)
    if out.suffix.lower() != ".zip":
        raise UsageError(f"A bundle is a ZIP file. Name it FILE.zip instead of {out}.")
    if models is not None:
        read_manifest(existing(models, "model folder"))
    given = None if video is None else existing(video, "video")
    source = find_sources([run], home, given if _is_bare(run) else None, say)[0]
    with as_command_error():
        request = bundle_request(
            source,
            out,
            first if frames is not None else source.first,
            source.stop if stop is None else stop,
            note=note,
            tracks=[track_key(track) for track in tracks],
            video=given,
            expectation=expect,
            models=[] if models is None else [models],
            max_eq7=max_eq7,
            recording=recording,
        )
        request = replace(request, network=onnx)
    with step_counter("packing") as progress:
        report = make_bundle(request, progress)
    summary = report_summary(report)
    if json:
        print_json({"out": str(out), "run": source.run_id, "size": report.size, **summary})
    else:
        console = out_console()
        lead_in = plural(summary["lead_in"], "lead-in frame")
        console.print(
            f"{out}: frames {summary['first']} to {summary['stop'] - 1} and {lead_in}, {report.size / 2**20:.1f} MiB.",
            soft_wrap=True,
            markup=False,
        )
        for one in report.findings:
            mark = "right" if one.met else "WRONG"
            console.print(f"{mark}: {one.expected} {one.got}", soft_wrap=True, markup=False)
        if not report.findings:
            console.print("Without expectations, a replay compares the old output with the new one.", soft_wrap=True)
    for warning in report.warnings:
        say(f"warning: {warning}")


def _is_bare(name: str) -> bool:
    from tsr_engine.evidence.schema import RUN_FILE

    return (Path(name) / RUN_FILE).is_file()
