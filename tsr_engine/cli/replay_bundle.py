"""`tsr replay BUNDLE.zip`: the engine of this installation on a bug bundle, and the verdict."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from tsr_engine.cli.common import out_console, print_json, say, split_settings
from tsr_engine.json_shapes import JsonObject
from tsr_engine.plural import plural

if TYPE_CHECKING:
    from tsr_engine.bundle import Bundle, BundleReplay


def replay_bundle_file(
    path: Path,
    settings: Sequence[str],
    csv: Path | None,
    preset: str | None,
    models: Path | None,
    bundled_models: bool,
    json: bool,
    onnx: Path | None = None,
    other_models: bool = False,
) -> None:
    """Replay a bundle, print the report, and exit with the verdict's code.

    Raises:
        ImportFormatError: not a bundle, hostile, damaged, or of another format.
        UsageError: an invalid parameter, or both kinds of models are given.
        ModelError: the run used a network, and no option says which one to use.
    """
    from tsr_engine import bundle as bundles
    from tsr_engine import pipeline
    from tsr_engine.bundle.output import write_rows
    from tsr_engine.cli.interrupt import stop_on_interrupt
    from tsr_engine.cli.progress import progress_bar
    from tsr_engine.errors import UsageError
    from tsr_engine.io.atomic import atomic_text, refuse_inputs
    from tsr_engine.params import Params
    from tsr_engine.params.replayable import changed_parameters, refuse_missing_focus

    if bundled_models and models is not None:
        raise UsageError("--models and --bundled-models are two sets of models. Choose one of them.")
    refuse_inputs([csv], [path])
    pairs = split_settings(settings)
    with bundles.open_bundle(path) as bundle:
        before, changed = bundles.bundle_params(bundle)
        camera = [("coast_foe_y", before.tracking.coast_foe_y)]
        params = (before if preset is None else Params.preset(preset).with_settings(camera)).with_settings(pairs)
        refuse_missing_focus(before, params)
        changed += [f"The parameter {name} was changed for this replay." for name in changed_parameters(before, params)]
        folder = bundles.bundled_models(bundle) if bundled_models else models
        network = bundles.replay_network(bundle, onnx, bundled_models, other_models)
        components = pipeline.load_components(params, folder, network)
        with progress_bar("replaying", "frames") as show, stop_on_interrupt() as stopped:
            report = bundles.replay_bundle(
                bundle, params, components, changed=changed, progress=lambda n, m: show(n, m, ""), stop=stopped
            )
        if csv is not None:
            with atomic_text(csv) as out:
                write_rows(out, report.rows)
        if json:
            print_json(report_as_json(report, bundle, csv))
        else:
            print_report(report, bundle)
    if report.other_pictures:
        say(
            f"warning: {report.other_pictures} of {report.frames} pictures decode to other bits here than where the "
            "bundle was made."
        )
    raise typer.Exit(bundles.EXIT_CODES[report.verdict])


def report_as_json(report: BundleReplay, bundle: Bundle, csv: Path | None) -> JsonObject:
    """A report as JSON values."""
    from tsr_engine.bundle import EXIT_CODES

    frames = bundle.manifest.frames
    return {
        "verdict": report.verdict,
        "exit_code": EXIT_CODES[report.verdict],
        "note": bundle.manifest.note,
        "video": bundle.manifest.video.name,
        "first": frames.first,
        "stop": frames.stop,
        "expected": [
            {
                "id": outcome.id,
                "expected": outcome.expected,
                "before": outcome.before,
                "now": outcome.now,
                "verdict": outcome.verdict,
                "got": outcome.got,
                "frame": outcome.frame,
            }
            for outcome in report.outcomes
        ],
        "same_output": report.same,
        "tracks": report.tracks,
        "tracks_before": report.tracks_before,
        "frames_run": report.frames,
        "frames_judged": report.judged,
        "identical_frames": report.identical,
        "first_difference": report.first_difference,
        "other_pictures": report.other_pictures,
        "whole_lead_in": frames.whole_lead_in,
        "changed": report.changed,
        "seconds": round(report.seconds, 3),
        "csv": None if csv is None else str(csv),
    }


def print_report(report: BundleReplay, bundle: Bundle) -> None:
    """Print expectations, output, and the verdict in the last line."""
    console = out_console()
    manifest = bundle.manifest
    frames = manifest.frames
    console.print(
        f"{bundle.name}: frames {frames.first} to {frames.stop - 1} of {manifest.video.name}, "
        f"{_frames_run(report)} in {report.seconds:.1f} s.",
        soft_wrap=True,
        markup=False,
    )
    if manifest.note:
        console.print(f"Note: {manifest.note}", soft_wrap=True, markup=False)
    for text in report.changed:
        console.print(text, soft_wrap=True, markup=False)
    for outcome in report.outcomes:
        console.print(f"{outcome.verdict.upper()}: {outcome.expected}", soft_wrap=True, markup=False)
        console.print(f"    {outcome.got}", soft_wrap=True, markup=False)
    if not report.outcomes:
        console.print("The bundle has no expectations: the new output is compared with the old one.", soft_wrap=True)
    console.print(_reproduction(report, frames.whole_lead_in), soft_wrap=True, markup=False)
    console.print(report.verdict)


def _frames_run(report: BundleReplay) -> str:
    """The number of frames run, with the lead-in if there is one."""
    leading = report.frames - report.judged
    return f"{plural(report.frames, 'frame')} run" + (f" ({leading} of them to lead in)" if leading > 0 else "")


def _reproduction(report: BundleReplay, whole: bool) -> str:
    if report.identical is None:
        exact = "The stored evidence is of another version, so it was not compared bit by bit."
    elif report.identical == report.judged:
        exact = f"All {report.judged} frames are bit by bit those of the run."
    else:
        exact = f"{report.identical} of {report.judged} frames are bit by bit those of the run."
    shown = "The output is the same" if report.same else "The output is another one"
    tail = f"{shown} ({plural(report.tracks_before, 'track')} then, {report.tracks} now)."
    if not whole:
        tail += " Signs in view before the first frame were found anew, so the first frames may differ."
    return f"{exact} {tail}"
