"""`tsr batch`: many drives in, one folder of results each; on all cores of this machine, or on a Ray cluster."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import replace
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
    make_network,
    make_params,
    print_json,
    say,
)
from tsr_engine.cli.progress import CompilationNote
from tsr_engine.errors import InputError, UsageError
from tsr_engine.plural import plural

if TYPE_CHECKING:
    from tsr_engine.batch.run import BatchProgress, BatchRequest
    from tsr_engine.pipeline import Network

_KEEP_CHOICES = ("evidence", "csv", "video")
_LOG_INTERVAL_S = 30.0
"""Seconds between two lines of progress if stderr is not a terminal."""


PlaceOption = Annotated[
    str, typer.Option("--on", metavar="local|ray|ray://HOST:PORT", help="This machine, or a Ray cluster.")
]
JobsOption = Annotated[
    int | None,
    typer.Option(
        "--jobs", min=1, max=256, metavar="N", help="Drives at a time on this machine; unset: one for each core."
    ),
]
CoresOption = Annotated[
    int | None, typer.Option("--cores", min=1, max=64, metavar="N", help="Cores of one drive; unset: an equal share.")
]
MemoryOption = Annotated[
    int, typer.Option("--memory-mb", min=0, metavar="MIB", help="Address space of one drive's process; 0: any.")
]


def batch(
    inputs: Annotated[
        list[str],
        typer.Argument(metavar="INPUT...", help="Videos, folders, patterns, or @FILE with one of these on each line."),
    ],
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="Folder for the results, with one folder for each drive.")
    ],
    place: PlaceOption = "local",
    jobs: JobsOption = None,
    cores: CoresOption = None,
    keep: Annotated[
        str, typer.Option("--keep", metavar="WHAT,...", help="Results to keep: evidence, csv, video.")
    ] = "evidence,csv",
    memory: MemoryOption = 6144,
    preset: PresetOption = "default",
    settings: SetOption = [],  # noqa: B006 - typer copies it
    models: ModelsOption = None,
    onnx: OnnxOption = None,
    onnx_size: OnnxSizeOption = None,
    onnx_layout: OnnxLayoutOption = None,
    restart: Annotated[bool, typer.Option("--restart", help="Track all drives again.")] = False,
    json: JsonOption = False,
) -> None:
    """Track many drives, each in its own process; the result of a drive is complete or absent.

    The folder keeps a manifest (batch.json): after a stop the same command continues, skips finished drives and tries
    failed ones again. The summary (summary.html, summary.json) names failed drives; the others continue. Exit code 3:
    some drives failed.

    \b
    Examples:
      tsr batch drives/ --out results
      tsr batch 'archive/**/*.mp4' --out results --jobs 4 --set tau=25
      tsr batch @drives.txt --out /shared/results --on ray://head:10001 --keep csv
    """
    network = make_network(onnx, onnx_size, onnx_layout)
    from tsr_engine.batch.drives import find_drives
    from tsr_engine.batch.run import run_batch
    from tsr_engine.batch.summary import SUMMARY_HTML, summary_of
    from tsr_engine.cli.interrupt import leave_interrupted, stop_on_interrupt

    request = batch_request(
        find_drives(inputs), out, place, jobs, cores, _parse_keep(keep), memory, preset, settings, models, network
    )
    with stop_on_interrupt() as stopped:
        manifest = run_batch(replace(request, restart=restart), BatchProgressPrinter(), stopped)
    summary = summary_of(manifest)
    if json:
        print_json(summary)
    else:
        typer.echo(
            f"{plural(summary['done'], 'drive')} done, {summary['failed']} failed, {summary['waiting']} waiting; "
            f"{plural(sum(summary['signs'].values()), 'sign')} in {plural(summary['frames'], 'frame')}. "
            f"See {out / SUMMARY_HTML}."
        )
    if stopped():
        leave_interrupted(f"Finished drives are kept in {out}. Run the same command again to go on.")
    for failure in summary["failures"]:
        say(_failure(failure["drive"], failure["error"]))
    if summary["failed"]:
        raise InputError(f"{plural(summary['failed'], 'drive')} failed; the others are done. See {out / SUMMARY_HTML}.")


def _failure(drive: str, error: str) -> str:
    """One sentence on a failed drive; most errors name it already."""
    return error if drive in error else f"{drive}: {error}"


def batch_request(
    drives: Sequence[Path],
    out: Path,
    place: str,
    jobs: int | None,
    cores: int | None,
    kept: set[str],
    memory: int,
    preset: str,
    settings: Sequence[str],
    models: Path | None,
    network: Network | None,
    count: int | None = None,
) -> BatchRequest:
    """Make the request for the options of a batch.

    Args:
        drives: absolute paths; may be filled in later.
        out: folder of the results.
        place: value of --on.
        jobs: drives at a time; None: one per core.
        cores: cores per drive; None: an equal share.
        kept: some of evidence, csv, video.
        memory: limit on the address space of a process, MiB.
        preset: parameters to start from.
        settings: values of --set.
        models: folder of models; None: the shipped ones.
        network: network that replaces the ACF detector; None: no network.
        count: number of drives; None: that of ``drives``.

    Raises:
        UsageError: a value is invalid.
        ModelError: the models cannot be loaded.
    """
    from tsr_engine.batch.manifest import Identity
    from tsr_engine.batch.run import BatchRequest
    from tsr_engine.batch.task import DriveTask
    from tsr_engine.io.cores import usable_cores
    from tsr_engine.pipeline import load_components
    from tsr_engine.version import __version__

    target = _parse_place(place)
    params = make_params(preset, settings)
    digests = dict(load_components(params, models, network).models)
    parallel = min(count or len(drives), jobs or max(1, usable_cores() // (cores or 1)))
    task = DriveTask(
        video="",
        folder="",
        parameters=params.model_dump(mode="json"),
        models=None if models is None else str(models.absolute()),
        digests=digests,
        onnx=None if network is None else [str(network.path.absolute()), list(network.size), network.layout],
        evidence="evidence" in kept,
        csv="csv" in kept,
        annotated="video" in kept,
        cores=cores or (max(1, usable_cores() // parallel) if target == "local" else 1),
        memory_mb=memory,
    )
    return BatchRequest(drives, out, Identity(__version__, task.parameters, digests), task, target, parallel)


def _parse_keep(text: str) -> set[str]:
    kept = {word.strip() for word in text.split(",") if word.strip()}
    if unknown := sorted(kept - set(_KEEP_CHOICES)):
        raise UsageError(f"--keep expects some of {', '.join(_KEEP_CHOICES)}. Got {unknown[0]!r} instead.")
    return kept


def _parse_place(text: str) -> str:
    if text in ("local", "ray"):
        return text
    address = text.removeprefix("ray://")
    if address == text or not address:
        raise UsageError(f"--on expects local, ray or ray://HOST:PORT. Got {text!r} instead.")
    return address


class BatchProgressPrinter:
    """Reports the progress of a batch, and once that kernels are being compiled."""

    def __init__(self) -> None:
        self._terminal = sys.stderr.isatty()
        self._last = time.monotonic()
        self._print_compilation = CompilationNote()

    def __call__(self, progress: BatchProgress) -> None:
        """Report, unless the last report is recent."""
        if progress.note:
            self._print_compilation(progress.note)
            return
        is_over = progress.done + progress.failed == progress.total
        if not self._terminal and not is_over and time.monotonic() - self._last < _LOG_INTERVAL_S:
            return
        self._last = time.monotonic()
        rate = "" if progress.rate is None else f", {progress.rate:.0f} frames/s"
        left = "" if progress.remaining is None or is_over else f", {_duration(progress.remaining)} left"
        ended = f"{progress.done + progress.failed} of {plural(progress.total, 'drive')}"
        say(f"{ended}, {progress.failed} failed{rate}{left}.")


def _duration(seconds: float) -> str:
    hours, minutes = divmod(round(seconds / 60), 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min" if minutes else f"{seconds:.0f} s"
