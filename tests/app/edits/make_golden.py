"""Write tests/golden/edits/random.json anew: run it after a deliberate change of the semantics, read the difference.

Each case: documents, a command, what it leaves behind or the sentence it fails with, and what the result shows.
"""

from __future__ import annotations

import json
import random
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

from edit_toys import SPANS, a_box, a_command, beginning, machine
from pydantic import TypeAdapter

from app.edits.apply import CommandError, apply_command
from app.edits.commands import Command
from app.edits.effective import box_at

FOLDER = Path(__file__).parents[2] / "golden" / "edits"
ADAPTER: TypeAdapter[Any] = TypeAdapter(Command)


def cases(seed: int, walks: int, length: int) -> list[dict[str, Any]]:
    """Random walks over the toy tracks."""
    rng = random.Random(seed)
    found = []
    for walk in range(walks):
        docs = beginning()
        for frame in rng.sample(range(75), rng.randrange(4)):  # corrected here and there beforehand
            key = rng.choice(list(docs))
            raw = {"name": "set_box", "frame": frame, "key": key, "box": a_box(rng)}
            docs |= apply_command(docs, ADAPTER.validate_python(raw))
        for step in range(length):
            raw = a_command(rng, docs, step)
            case: dict[str, Any] = {
                "name": f"walk {walk} step {step}: {raw['name']}",
                "docs": {key: doc.model_dump(mode="json") for key, doc in docs.items()},
                "command": raw,
                "person": {"author": "ann", "time": "2026-01-02T03:04:05+00:00"},
            }
            try:
                changed = apply_command(docs, ADAPTER.validate_python(raw), **case["person"])
            except CommandError as error:
                case["error"] = str(error)
            else:
                docs = {**docs, **changed}
                case["expected"] = {key: doc.model_dump(mode="json") for key, doc in changed.items()}
                case["shown"] = [
                    [
                        key,
                        f,
                        None
                        if (s := box_at(doc, f, machine)) is None
                        else [list(s.box), s.origin, s.occluded, s.class_id],
                    ]
                    for key, doc in changed.items()
                    for f in sorted(rng.sample(range(75), 6))
                ]
            found.append(case)
    return found


def main() -> None:
    """Write the file."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    body = {"spans": {str(t): span for t, span in SPANS.items()}, "cases": cases(7, 60, 7)}
    lines = ",\n".join(json.dumps(case, separators=(",", ":")) for case in body["cases"])
    (FOLDER / "random.json").write_text(f'{{"spans":{json.dumps(body["spans"])},\n"cases":[\n{lines}\n]}}\n')


if __name__ == "__main__":
    main()
