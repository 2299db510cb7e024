"""Run experiments and write the report: ``python -m benchmarks --help``."""

from __future__ import annotations

import argparse
import fcntl
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path

from benchmarks.experiment import ROOT, Data, Experiment, Result, Skip, machine
from benchmarks.experiments import EXPERIMENTS
from benchmarks.reporting.report import write_report
from tsr_engine.errors import InputError, TsrError, UsageError

RESULTS = ROOT / "results"


def main(argv: Sequence[str] | None = None) -> int:
    """Run the named experiments, and write the report from all stored results."""
    names = [experiment.name for experiment in EXPERIMENTS]
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"experiments: {', '.join(names)}; unset: all")
    for folder in fields(Data):
        if "help" in folder.metadata:
            parser.add_argument(f"--{folder.name}", type=Path, help=folder.metadata["help"])
    parser.add_argument("--scratch", type=Path, default=Path("out/bench"))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, help="time of one call of `scale`; the next call continues")
    parser.add_argument(
        "--beside", action="store_true", help="keep stored results; add to each a line with this processor's figures"
    )
    parser.add_argument("--report", action="store_true", help="only write the report, from stored results")
    args = parser.parse_args(argv)
    unknown = sorted(set(args.names) - set(names))
    if unknown:
        parser.error(f"there is no experiment {', '.join(unknown)}; choose from {', '.join(names)}")
    args.scratch.mkdir(parents=True, exist_ok=True)
    data = Data(**{field.name: getattr(args, field.name) for field in fields(Data)})
    chosen = [] if args.report else [e for e in EXPERIMENTS if not args.names or e.name in args.names]
    try:
        measured: list[str] = []
        if chosen:
            with alone(args.scratch):
                measured = _run(chosen, data, args.beside)
        write_report(EXPERIMENTS, RESULTS, ROOT / "figures", ROOT / "REPORT.md", measured)
    except TsrError as error:
        sys.stderr.write(f"benchmarks: {error}\n")
        return error.exit_code
    return 0


@contextmanager
def alone(scratch: Path) -> Iterator[None]:
    """Lock the scratch folder, since experiments share the files that they make there.

    Raises:
        UsageError: another process runs experiments in this folder.
    """
    with (scratch / "running").open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise UsageError(
                f"Other experiments run in {scratch}, and experiments share their files there. Wait for them, or name "
                "another folder with --scratch."
            ) from None
        yield


def _run(experiments: Sequence[Experiment], data: Data, beside: bool) -> list[str]:
    """Run experiments and store their results; return the names of those that were measured."""
    stored_results = {e.name: Result.load(path) for e in experiments if (path := RESULTS / f"{e.name}.json").is_file()}
    if beside:
        for experiment in experiments:
            _require_other_processor(experiment, stored_results.get(experiment.name))
    measured = []
    for experiment in experiments:
        stored = stored_results.get(experiment.name)
        began = time.monotonic()
        sys.stderr.write(f"{experiment.name} ... ")
        sys.stderr.flush()
        try:
            if not beside:
                _require_folders(experiment, stored, data)
            result = replace(experiment.run(data), name=experiment.name, machine=machine())
        except (Skip, InputError) as why:
            if stored is not None and not stored.skipped:
                sys.stderr.write(f"skipped, the stored result stays: {why}\n")
            else:
                sys.stderr.write(f"skipped: {why}\n")
                Result(experiment.name, skipped=str(why), machine=machine()).save(RESULTS)
            continue
        result = replace(result, folders=[name for name in experiment.optional if data.has(name)])
        sys.stderr.write(f"done ({time.monotonic() - began:.0f} s)\n")
        if experiment.headline is not None:
            kept = stored if beside else None
            headline = experiment.headline
            result = result.beside(stored, headline) if kept is None else kept.beside(result, headline)
        result.save(RESULTS)
        measured.append(experiment.name)
    return measured


def _require_folders(experiment: Experiment, stored: Result | None, data: Data) -> None:
    """Check that a new result would have all figures of the stored one.

    Raises:
        Skip: a folder is missing that the stored result used.
    """
    if stored is None or stored.skipped:
        return
    used = experiment.optional if stored.folders is None else stored.folders
    missing = [f"--{name}" for name in used if not data.has(name)]
    if missing:
        raise Skip(
            f"it has figures of further folders. Name them with {', '.join(missing)}, or remove "
            f"{RESULTS.name}/{experiment.name}.json to measure without them."
        )


def _require_other_processor(experiment: Experiment, stored: Result | None) -> None:
    """Check that the figures of this processor can be added to a stored result."""
    if experiment.headline is None:
        raise UsageError(f"No figure of {experiment.name} depends on the processor. Run it without --beside.")
    if stored is None or stored.skipped:
        raise UsageError(f"There is no stored result of {experiment.name}. Run it without --beside.")
    if stored.machine["processor"] == machine()["processor"]:
        raise UsageError(f"The stored result of {experiment.name} is of this processor. Run it without --beside.")


if __name__ == "__main__":
    raise SystemExit(main())
