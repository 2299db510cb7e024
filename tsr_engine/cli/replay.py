"""`tsr replay`: a run once more from its evidence with other parameters, or a bug bundle once more from its clip."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tsr_engine.cli.common import JsonOption, ModelsOption, SetOption, out_console, print_json, say, split_settings
from tsr_engine.cli.replay_bundle import replay_bundle_file
from tsr_engine.errors import EvidenceError, UsageError
from tsr_engine.json_shapes import JsonObject
from tsr_engine.plural import plural

if TYPE_CHECKING:
    from tsr_engine.params import Params
    from tsr_engine.runs.replay import ReplayReport


def replay(
    evidence: Annotated[
        Path,
        typer.Argument(metavar="EVIDENCE|BUNDLE", help="A folder from `tsr track --evidence`, or a bug bundle (.zip)."),
    ],
    settings: SetOption = [],  # noqa: B006 - typer copies it
    csv: Annotated[
        Path | None, typer.Option("--csv", metavar="OUT", help="Write one row for each track and frame.")
    ] = None,
    preset: Annotated[
        str | None,
        typer.Option("--preset", metavar="default|realtime|paper", help="Start from a preset, not from the run."),
    ] = None,
    models: ModelsOption = None,
    other_models: Annotated[
        bool, typer.Option("--other-models", help="Allow models other than those of the run.")
    ] = False,
    bundled_models: Annotated[
        bool, typer.Option("--bundled-models", help="For a bundle: use the models inside, not those of this machine.")
    ] = False,
    onnx: Annotated[
        Path | None, typer.Option("--onnx", metavar="FILE", help="For a bundle: the ONNX network of its run.")
    ] = None,
    json: JsonOption = False,
) -> None:
    """Run everything after detection again from a run's evidence, or the whole engine on a bug bundle.

    A replay of evidence takes seconds. Unset parameters are those of the run; without --set the result equals the run
    bit by bit. The table shows which tracks were gained, lost, split or relabelled. Parameters of decoding, detection
    and camera shift cannot be changed.

    A bundle is replayed at the engine's speed: this version and these models run on its clip, and the last line says
    fixed (exit code 0), still broken (20) or different (21). A bundle that expects nothing cannot be fixed: its output
    is unchanged (20) or different (21).

    \b
    Examples:
      tsr replay run1
      tsr replay run1 --set tau=25 --csv rows.csv
      tsr replay run1 --set prior_lambda=2 --set search_radius=40
      tsr replay bug.zip
      tsr replay bug.zip --set tau=25 --json
    """
    from tsr_engine.bundle.load import is_bundle

    if is_bundle(evidence):
        replay_bundle_file(evidence, settings, csv, preset, models, bundled_models, json, onnx, other_models)
    for option, given in (("--bundled-models", bundled_models), ("--onnx", onnx is not None)):
        if given:
            raise UsageError(f"{option} is for a bug bundle. Leave it out for an evidence folder.")
    pairs = split_settings(settings)
    from tsr_engine.cli.interrupt import stop_on_interrupt
    from tsr_engine.cli.progress import progress_bar
    from tsr_engine.evidence import RESULT_HEADER, EvidenceReader, refuse_run_files
    from tsr_engine.io.atomic import atomic_text
    from tsr_engine.params import Params
    from tsr_engine.params.replayable import changed_parameters
    from tsr_engine.pipeline import ResultStream, load_components
    from tsr_engine.runs.replay import ReplayReport, check_models, run_params
    from tsr_engine.runs.replay import replay as replay_run

    if csv is not None:
        refuse_run_files([csv], evidence)
    with EvidenceReader(evidence) as reader:
        if not len(reader):
            raise EvidenceError(f"{evidence} holds no frame yet. Track the video first.")
        before = run_params(reader)
        start = before if preset is None else _with_camera_of_run(before, Params.preset(preset))
        params = start.with_settings(pairs)
        components = load_components(params, models)
        if not other_models:
            check_models(reader, components, params)
        if reader.state != "complete":
            replayed = plural(len(reader), "frame is", "frames are")
            say(f"warning: the run in {evidence} is {reader.state}: {replayed} replayed.")
    report, results = ReplayReport(), ResultStream()
    with progress_bar("replaying", "frames") as show, stop_on_interrupt() as stopped:
        frames = replay_run(evidence, params, components, report=report, on_frame=lambda _, n, m: show(n, m, ""))
        if csv is None:
            for _ in frames:
                _raise_if_stopped(stopped)
        else:
            with atomic_text(csv) as out:
                out.write(RESULT_HEADER + "\n")
                for frame in frames:
                    out.writelines(row.line() + "\n" for row in results.add(frame))
                    _raise_if_stopped(stopped)
                out.writelines(row.line() + "\n" for row in results.finish())
    changed = changed_parameters(before, params)
    if json:
        print_json(report_as_json(report, changed, csv))
    else:
        print_report(report, changed)
    if not changed and not other_models and report.identical != report.frames:
        other = plural(report.frames - report.identical, "frame differs", "frames differ")
        say(f"warning: {other} from the run, first at {report.first_difference}.")
    if report.missing_pixels:
        say(
            f"warning: the evidence lacks {plural(report.missing_pixels, 'pixel')} in "
            f"{plural(report.missing_frames, 'frame')}; the nearest stored ones were used. "
            "Track again with a larger keep_radius for exact results."
        )


_CAMERA_PARAMETERS = ("use_camera_shift", "shift_scale", "foe_x", "foe_y", "coast_foe_y")
"""Parameters of tracking that belong to the run's camera shifts and its camera."""


def _with_camera_of_run(run: Params, preset: Params) -> Params:
    """A preset with the run's parameters for its camera and for steps that a replay does not repeat."""
    tracking = preset.tracking.model_copy(update={name: getattr(run.tracking, name) for name in _CAMERA_PARAMETERS})
    return preset.model_copy(update={"detector": run.detector, "tracking": tracking})


def _raise_if_stopped(stopped: Callable[[], bool]) -> None:
    if stopped():
        raise KeyboardInterrupt


def report_as_json(report: ReplayReport, changed: list[str], csv: Path | None) -> JsonObject:
    """The report of a replay as JSON values."""
    from tsr_engine.runs.report_json import track_as_json

    return {
        "frames": report.frames,
        "identical_frames": report.identical,
        "changed_parameters": changed,
        "missing_pixels": report.missing_pixels,
        "missing_frames": report.missing_frames,
        "seconds": round(report.seconds, 3),
        "csv": None if csv is None else str(csv),
        "tracks": [track_as_json(track, report.class_names) for track in report.tracks],
        "gained": list(report.diff.gained),
        "lost": list(report.diff.lost),
        "switched": [{"track_id": a, "now": list(b)} for a, b in report.diff.switched],
        "relabelled": [{"track_id": t, "before": a, "now": b} for t, a, b in report.diff.relabelled],
    }


def print_report(report: ReplayReport, changed: list[str]) -> None:
    """Print what was replayed, the tracks, and differences from the run."""
    from tsr_engine.cli.track import track_table
    from tsr_engine.runs.report_json import class_name

    console = out_console()
    what = ", ".join(changed) if changed else "no parameter changed"
    console.print(
        f"{plural(report.frames, 'frame')} replayed in {report.seconds:.1f} s ({what}); "
        f"{plural(report.identical, 'is', 'are')} identical.",
        soft_wrap=True,
    )
    if report.tracks:
        console.print(track_table(report.tracks, report.class_names))
    diff = report.diff
    if not diff:
        same = report.identical == report.frames
        console.print(f"The same tracks as in the run{'' if same else ', in other frames or with other boxes'}.")
        return
    for title, ids in (("Gained", diff.gained), ("Lost", diff.lost)):
        if ids:
            console.print(f"{title}: {', '.join(f'track {i}' for i in ids)}", soft_wrap=True)
    for old, now in diff.switched:
        console.print(f"Split: track {old} of the run is now {', '.join(map(str, now))}", soft_wrap=True)
    for track_id, old, new in diff.relabelled:
        was, became = (class_name(label, report.class_names) for label in (old, new))
        console.print(f"Relabelled: track {track_id}, '{was}' is now '{became}'", soft_wrap=True)
