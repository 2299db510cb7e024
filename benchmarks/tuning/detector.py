"""Compares options of the detector's training, without the scenes of reported figures.

    python -m benchmarks.tuning.detector --gtsdb GTSDB --gtsrb GTSRB [--part 0] [--set shrinkage=1 --set aspect=0]

The scenes that the shipped detector's figures do not use are divided into parts. For each part, a detector is trained
on the other parts. Each half of the part calibrates the detector for the other half. A part takes about 12 minutes on
one core; parts can run in parallel. Nothing is written.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar, get_type_hints

from pydantic import TypeAdapter, ValidationError

from benchmarks.corruptions.cameras import by_version
from tsr_engine.detection.acf import AcfDetector
from tsr_engine.errors import TsrError, UsageError
from tsr_engine.evaluation.detection import score_detections
from tsr_engine.io.gtsdb import Scene, read_gtsdb
from tsr_engine.io.gtsrb import read_items
from tsr_engine.json_shapes import JsonObject
from tsr_engine.params.detector import DetectorParams
from tsr_engine.training.public.detector import DetectorPlan, fit_detector
from tsr_engine.training.public.detector_components import (
    AS_ANNOTATED,
    calibrate_model,
    detect_scenes,
    detection_figures,
    split_scenes,
)

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Plan = TypeVar("Plan", bound="DataclassInstance")
ANY_SCORE = 1000.0
"""Rate of false detections per picture that keeps all detections."""


def parts(scenes: Sequence[Scene], count: int, seed: int) -> list[tuple[list[Scene], list[Scene]]]:
    """Training scenes and test scenes of each part, without the scenes of reported figures."""
    train, calibrate, _ = split_scenes(scenes, seed)
    pool = train + calibrate
    return [
        ([s for i, s in enumerate(pool) if i % count != part], [s for i, s in enumerate(pool) if i % count == part])
        for part in range(count)
    ]


def plan_with(settings: Sequence[str]) -> DetectorPlan:
    """The default plan with changed values, each ``name=value``; values are JSON, nested names are joined by dots.

    Raises:
        UsageError: a name is unknown, or a value is not JSON.
    """
    plan = DetectorPlan()
    for setting in settings:
        name, _, text = setting.partition("=")
        try:
            value = json.loads(text)
        except ValueError:
            raise UsageError(f"The value of {name} must be JSON. Got {text!r} instead.") from None
        plan = _replaced(plan, name.split("."), value, name)
    return plan


def _replaced(plan: Plan, path: Sequence[str], value: object, name: str) -> Plan:
    names = [field.name for field in fields(plan)] if is_dataclass(plan) else []
    if path[0] not in names:
        raise UsageError(f"A training has no option {name!r}. It has {', '.join(names)} there.")
    if len(path) > 1:
        value = _replaced(getattr(plan, path[0]), path[1:], value, name)
    elif is_dataclass(getattr(plan, path[0])):
        raise UsageError(f"{name} is a group of options. Choose one of them: {name}.NAME=VALUE.")
    try:
        kind = TypeAdapter(get_type_hints(type(plan))[path[0]])
        return replace(plan, **{path[0]: kind.validate_python(value)})
    except ValidationError as error:
        raise UsageError(f"{name} cannot be {value!r}: {error.errors()[0]['msg']}") from None
    except ValueError as error:
        raise UsageError(f"{name} cannot be {value!r}: {error}") from None


def figures(
    train: Sequence[Scene],
    held: Sequence[Scene],
    gtsrb: Path | None,
    plan: DetectorPlan,
    seed: int,
    params: DetectorParams = AS_ANNOTATED,
) -> JsonObject:
    """AP, recalls, number of signs without a detection at any score, and losses of other cameras, for one part."""
    progress = _Progress()
    model, _ = fit_detector(train, read_items(gtsrb) if gtsrb else [], plan, seed, progress)
    halves = [list(held[0::2]), list(held[1::2])]
    found = []
    versions: dict[str, Counter[str]] = defaultdict(Counter)
    for own, other in (halves, halves[::-1]):
        calibrated = replace(model, calibration=calibrate_model(model, other, seed, progress))
        found += detect_scenes(calibrated, own, progress, params)
        for name, row in by_version(AcfDetector(calibrated, params=params), own, seed, progress).items():
            versions[name].update(row)
    score = score_detections(found)
    lost = round(score.signs * (1 - score.recall_at(ANY_SCORE)))
    return {**detection_figures(found), "lost": lost, "versions": versions}


class _Progress:
    """Prints each stage once to standard error."""

    def __init__(self) -> None:
        self._last = ""

    def __call__(self, stage: str, done: int, total: int) -> None:
        if stage != self._last:
            self._last = stage
            sys.stderr.write(f"  {stage}\n")
            sys.stderr.flush()


def main(argv: Sequence[str] | None = None) -> int:
    """Train, and print one line of JSON for each part."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.tuning.detector", description=__doc__)
    parser.add_argument("--gtsdb", type=Path, required=True)
    parser.add_argument("--gtsrb", type=Path, help="GTSRB crops; unset: only scenes are used")
    parser.add_argument("--parts", type=int, default=3)
    parser.add_argument("--part", type=int, help="part to run; unset: all, one after another")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--passes", type=int, help="passes of the box refinement; unset: the detector's default")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="option of the training")
    args = parser.parse_args(argv)
    try:
        plan = plan_with(args.set)
        if args.parts < 2 or (args.part is not None and not 0 <= args.part < args.parts):
            raise UsageError(f"There must be two parts or more, and --part one of them. Got {args.parts}, {args.part}.")
        passes = AS_ANNOTATED.refine_passes if args.passes is None else args.passes
        try:
            params = DetectorParams.model_validate(AS_ANNOTATED.model_dump() | {"refine_passes": passes})
        except ValidationError as error:
            raise UsageError(f"--passes cannot be {args.passes}: {error.errors()[0]['msg']}") from None
        cut = parts(read_gtsdb(args.gtsdb), args.parts, args.seed)
        for part in range(args.parts) if args.part is None else [args.part]:
            train, held = cut[part]
            row = figures(train, held, args.gtsrb, plan, args.seed, params)
            print(json.dumps({"part": part, "set": args.set, **row}), flush=True)
    except TsrError as error:
        sys.stderr.write(f"tuning.detector: {error}\n")
        return error.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(main())
