"""Makes the shipped set ``vienna`` from its table: ``python -m tsr_engine.labels.make_vienna``.

Each row of the table, ``sets/vienna.csv``, describes one sign. Rows of the 43 signs of
``gtsrb-43`` only extend them: aliases, and mirror images that ``gtsrb-43`` lacks.
"""

from __future__ import annotations

import csv
from importlib import resources
from pathlib import Path

from tsr_engine.labels.files import VIENNA, save_set, shipped_set
from tsr_engine.labels.model import Attribute, Label, LabelSet

SETS = Path(str(resources.files("tsr_engine.labels"))) / "sets"
TARGET = SETS / "vienna.json"
"""The shipped file."""

TEMPORARY = Attribute(name="temporary", kind="checkbox", default=False)
"""Marks signs only for road works, with a yellow or orange ground in most countries."""
MAY_BE_TEMPORARY = frozenset({"danger", "direction", "mandatory", "priority", "prohibitory"})
"""Categories whose signs have the attribute ``temporary``."""


def make_vienna() -> LabelSet:
    """Build the set from the current table.

    Raises:
        ValueError: a row breaks a rule of label sets, ids are not consecutive, or a row of the 43 has another key.
    """
    known = {label.id: label for label in shipped_set("gtsrb-43")}
    labels = []
    with (SETS / "vienna.csv").open(encoding="utf-8", newline="") as file:
        for number, row in enumerate(csv.DictReader(file)):
            if row["id"] != str(number):
                raise ValueError(f"vienna.csv: the row of {row['key']!r} has id {row['id']}, but {number} is next")
            label = _extended(known[number], row) if number in known else _label(row)
            asked = (TEMPORARY,) if label.category in MAY_BE_TEMPORARY else ()
            labels.append(label.model_copy(update={"attributes": asked}))
    return LabelSet(
        key=VIENNA,
        name="Vienna Convention on Road Signs and Signals, annex 1",
        next_id=len(labels),
        labels=tuple(labels),
    )


def _aliases(row: dict[str, str]) -> tuple[str, ...]:
    return tuple(alias.strip() for alias in row["aliases"].split(";") if alias.strip())


def _extended(label: Label, row: dict[str, str]) -> Label:
    """A label of the 43 with further aliases."""
    if row["key"] != label.key:
        raise ValueError(f"vienna.csv: id {label.id} must be {label.key!r}, as in gtsrb-43, not {row['key']!r}")
    changes = {"aliases": (*label.aliases, *_aliases(row)), "mirror": row["mirror"] or label.mirror}
    return Label.model_validate(label.model_dump() | changes)


def _label(row: dict[str, str]) -> Label:
    return Label.model_validate(
        {
            "id": int(row["id"]),
            "key": row["key"],
            "name": row["name"],
            "short": row["short"],
            "aliases": _aliases(row),
            "shape": row["shape"],
            "category": row["category"],
            "pictogram": f"vienna/{row['key']}",
            "size_mm": float(row["size_mm"]) if row["size_mm"] else None,
            "mirror": row["mirror"] or None,
        }
    )


if __name__ == "__main__":
    save_set(make_vienna(), TARGET)
    print(TARGET)
