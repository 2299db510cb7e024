"""Write tests/golden/edits again after a deliberate change of the semantics; review the difference.

Each case has documents, a command, its resulting documents or error sentence, and the shown tracks.
"""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from app.edits.apply import CommandError, apply_command
from app.edits.commands import Command
from app.edits.documents import TrackDoc
from app.edits.effective import box_at
from tests.app.edits.random_commands import (
    SPANS,
    engine_box,
    initial_documents,
    random_attribute_command,
    random_box,
    random_command,
)

FOLDER = Path(__file__).parents[2] / "golden" / "edits"
ADAPTER: TypeAdapter[Any] = TypeAdapter(Command)


def cases(seed: int, walks: int, length: int, choose: Callable[..., dict[str, Any]]) -> list[dict[str, Any]]:
    """Random walks over the toy tracks."""
    rng = random.Random(seed)
    found = []
    for walk in range(walks):
        docs = initial_documents()
        for frame in rng.sample(range(75), rng.randrange(4)):  # with some earlier corrections
            key = rng.choice(list(docs))
            raw = {"name": "set_box", "frame": frame, "key": key, "box": random_box(rng)}
            docs |= apply_command(docs, ADAPTER.validate_python(raw))
        for step in range(length):
            raw = choose(rng, docs, step)
            case, docs = _case(f"walk {walk} step {step}: {raw['name']}", docs, raw, rng)
            found.append(case)
    return found


def splits(seed: int) -> list[dict[str, Any]]:
    """Tracks that continue beyond their engine's boxes, split there and elsewhere."""
    rng = random.Random(seed)
    docs = initial_documents()
    for raw in (
        {"name": "set_box", "frame": 30, "key": "m1", "box": random_box(rng)},
        {"name": "set_box", "frame": 40, "key": "m1", "box": random_box(rng)},
        {"name": "interpolate", "frame": 30, "key": "m1", "first": 30, "last": 40, "value": True},
        {"name": "create_track", "frame": 45, "key": "hdrawn01", "box": random_box(rng)},
        {"name": "merge", "frame": 45, "key": "hdrawn01", "others": ["m3"]},
    ):
        docs |= apply_command(docs, ADAPTER.validate_python(raw))
    found = []
    for key, frame in (("m1", 10), ("m1", 25), ("m1", 35), ("hdrawn01", 48), ("hdrawn01", 60)):
        for reported in ({}, {"class_id": 14}):
            raw = {"name": "split", "frame": frame, "key": key, "new_key": "hpart0001", **reported}
            found.append(_case(f"{key} at {frame}, told {reported.get('class_id')}", docs, raw, rng)[0])
    return found


def cuts(seed: int) -> list[dict[str, Any]]:
    """A line across key frames without a box, cut there and elsewhere; then with a gap between these key frames."""
    rng = random.Random(seed)
    docs = initial_documents()
    line = [
        {"name": "set_occluded", "frame": 8, "key": "m1", "value": True},
        {"name": "set_box", "frame": 3, "key": "m1", "box": random_box(rng)},
        {"name": "set_box", "frame": 18, "key": "m1", "box": random_box(rng)},
        {"name": "interpolate", "frame": 3, "key": "m1", "first": 3, "last": 18, "value": True},
    ]
    gap = [
        {**line[-1], "value": False},
        {"name": "set_occluded", "frame": 12, "key": "m1", "value": True},
        line[-1],
        {"name": "set_box", "frame": 25, "key": "m1", "box": [1, 1, 9, 9]},
        {"name": "interpolate", "frame": 8, "key": "m1", "first": 8, "last": 25, "value": False},
        {"name": "interpolate", "frame": 12, "key": "m1", "first": 12, "last": 25, "value": True},
    ]
    found = []
    for what, commands, frames in (("", line, (8, 9, 12)), ("with a gap, ", gap, (6, 10, 14))):
        for raw in commands:
            docs |= apply_command(docs, ADAPTER.validate_python(raw))
        for frame in frames:
            for name, new in (("delete_from", {}), ("split", {"new_key": "hpart0001"})):
                raw = {"name": name, "frame": frame, "key": "m1", **new}
                found.append(_case(f"{what}{name} at {frame}", docs, raw, rng)[0])
    return found


def _case(
    name: str, docs: dict[str, TrackDoc], raw: dict[str, Any], rng: random.Random
) -> tuple[dict[str, Any], dict[str, TrackDoc]]:
    """A case, and all documents after it."""
    case: dict[str, Any] = {
        "name": name,
        "docs": {key: doc.model_dump(mode="json") for key, doc in docs.items()},
        "command": raw,
        "person": {"author": "ann", "time": "2026-01-02T03:04:05+00:00"},
    }
    try:
        changed = apply_command(docs, ADAPTER.validate_python(raw), **case["person"])
    except CommandError as error:
        case["error"] = str(error)
        return case, docs
    case["expected"] = {key: doc.model_dump(mode="json") for key, doc in changed.items()}
    case["shown"] = [
        [
            key,
            f,
            None if (s := box_at(doc, f, engine_box)) is None else [list(s.box), s.origin, s.occluded, s.class_id],
            *([doc.attributes_at(f)] if doc.attributes_at(f) else []),
        ]
        for key, doc in changed.items()
        for f in sorted(rng.sample(range(75), 6))
    ]
    return case, {**docs, **changed}


def main() -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    spans = json.dumps({str(t): span for t, span in SPANS.items()})
    made = {
        "random": cases(7, 60, 7, random_command),
        "splits": splits(7),
        "cuts": cuts(7),
        "attributes": cases(7, 24, 9, random_attribute_command),
    }
    for name, found in made.items():
        lines = ",\n".join(json.dumps(case, separators=(",", ":")) for case in found)
        (FOLDER / f"{name}.json").write_text(f'{{"spans":{spans},\n"cases":[\n{lines}\n]}}\n')


if __name__ == "__main__":
    main()
