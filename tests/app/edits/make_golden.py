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
from app.edits.documents import OPEN_END, Segment, TrackDoc
from app.edits.effective import box_at
from tests.app.edits.random_commands import (
    SPANS,
    engine_box,
    initial_documents,
    interrupted_lines,
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
    for key in ("m1", "hdrawn01"):
        merged = docs | apply_command(
            docs, ADAPTER.validate_python({"name": "merge", "frame": 0, "key": key, "others": ["m2"]})
        )
        raw = {"name": "split", "frame": 50 if key == "hdrawn01" else 25, "key": key, "new_key": "hpart0001"}
        found.append(_case(f"{key} with two engine tracks", merged, {**raw, "class_id": 14}, rng)[0])
    return found


def cuts(seed: int) -> list[dict[str, Any]]:
    """Lines across a key frame without a box, which may interrupt them, cut at that frame and elsewhere."""
    rng = random.Random(seed)
    docs = _edited(
        {"name": "set_occluded", "frame": 8, "key": "m1", "value": True},
        {"name": "set_box", "frame": 3, "key": "m1", "box": random_box(rng)},
        {"name": "set_box", "frame": 18, "key": "m1", "box": random_box(rng)},
        {"name": "interpolate", "frame": 3, "key": "m1", "first": 3, "last": 18, "value": True},
    )
    found = []
    for frame in (8, 9, 12):
        found += _cut(docs, "m1", frame, rng)
    docs = _edited(*interrupted_lines(random_box(rng), random_box(rng)))
    for key, frame in (("m1", 9), ("m1", 12), ("m2", 23), ("m2", 30)):
        found += _cut(docs, key, frame, rng)
    return found


def merges(seed: int) -> list[dict[str, Any]]:
    """An earlier engine track merged into tracks with the engine's label, with a person's, and without one."""
    rng = random.Random(seed)
    docs = _edited(
        {"name": "split", "frame": 60, "key": "m3", "new_key": "hpart0001"},
        {"name": "create_track", "frame": 45, "key": "hdrawn01", "box": random_box(rng)},
        {"name": "create_track", "frame": 46, "key": "hnamed01", "box": random_box(rng), "class_id": 3},
    )
    found = []
    for key, class_id in (("hpart0001", 14), ("hpart0001", None), ("hdrawn01", None), ("hnamed01", None), ("m3", 14)):
        raw = {"name": "merge", "frame": 60, "key": key, "others": ["m1"], "class_id": class_id}
        found.append(_case(f"m1 into {key}, told {class_id}", docs, raw, rng)[0])
    docs |= _edited(
        {"name": "create_track", "frame": 4, "key": "hline001", "box": random_box(rng)},
        {"name": "set_box", "frame": 64, "key": "hline001", "box": random_box(rng)},
    )
    docs["m1"] = docs["m1"].model_copy(update={"segments": (Segment(track=1, first=0, last=OPEN_END),)})
    gaps = [{"track": 1, "first": first, "last": last} for first, last in ((6, 6), (13, 13), (20, OPEN_END))]
    for key, others in (("m1", ["hline001"]), ("m1", ["m3"]), ("hpart0001", ["m1"])):
        raw = {"name": "merge", "frame": 60, "key": key, "others": others, "gaps": gaps}
        found.append(_case(f"{others[0]} into {key} with gaps", docs, raw, rng)[0])
    return found


def _edited(*commands: dict[str, Any]) -> dict[str, TrackDoc]:
    docs = initial_documents()
    for raw in commands:
        docs |= apply_command(docs, ADAPTER.validate_python(raw))
    return docs


def _cut(docs: dict[str, TrackDoc], key: str, frame: int, rng: random.Random) -> list[dict[str, Any]]:
    found = []
    for name, new in (("delete_from", {}), ("split", {"new_key": "hpart0001"})):
        raw = {"name": name, "frame": frame, "key": key, **new}
        found.append(_case(f"{name} at {frame}", docs, raw, rng)[0])
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
        "merges": merges(7),
        "attributes": cases(7, 24, 9, random_attribute_command),
    }
    for name, found in made.items():
        lines = ",\n".join(json.dumps(case, separators=(",", ":")) for case in found)
        (FOLDER / f"{name}.json").write_text(f'{{"spans":{spans},\n"cases":[\n{lines}\n]}}\n')


if __name__ == "__main__":
    main()
