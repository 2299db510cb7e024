"""Maps class numbers in a run's evidence to the label set of its video."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

from sqlalchemy.orm import Session

from app.labels.store import labels_of_run
from app.storage.models import Run
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.labels.classes import RunClasses, classes_of_keys, classes_of_set
from tsr_engine.labels.model import LabelSet

__all__ = ["RunClasses", "classes_in", "labels_of_model", "reported_classes", "run_classes"]


def classes_in(session: Session, run: Run) -> RunClasses:
    """Like :func:`run_classes`, with the newest version of the set of the run's video."""
    return run_classes(run, labels_of_run(session, run))


def labels_of_model(keys: Sequence[str] | None) -> JsonObject | None:
    """``Run.labels`` for a model whose classes have these keys; None: those of ``gtsrb-43``."""
    return None if keys is None else {"keys": list(keys)}


def run_classes(run: Run, labels: LabelSet) -> RunClasses:
    """Map the class numbers in a run's evidence to labels.

    Args:
        run: its ``labels`` say what its numbers are: keys by number, ids of a set, or (None) ``gtsrb-43``.
        labels: the set of the run's video.
    """
    return reported_classes(run.labels, labels)


def reported_classes(reported: JsonMapping | None, labels: LabelSet) -> RunClasses:
    """Like :func:`run_classes`, from ``Run.labels`` alone."""
    keys = None if reported is None else reported.get("keys")
    return _classes(None if keys is None else tuple(keys), (reported or {}).get("set"), _Version(labels))


class _Version:
    """One version of a set as a cache key; versions are immutable, so the identity of the object is enough."""

    def __init__(self, labels: LabelSet) -> None:
        self.labels = labels

    def __hash__(self) -> int:
        return id(self.labels)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Version) and other.labels is self.labels


@lru_cache(maxsize=64)
def _classes(keys: tuple[str, ...] | None, of_set: str | None, version: _Version) -> RunClasses:
    if of_set is not None:
        return classes_of_set(of_set, version.labels)
    return classes_of_keys(keys, version.labels)
