"""Toy tracks and random, often valid commands for the tests of edits."""

from __future__ import annotations

import random
from typing import Any

from pydantic import TypeAdapter

from app.edits.apply import CommandError, apply_command
from app.edits.commands import Command
from app.edits.documents import TrackDoc, engine_doc

ADAPTER: TypeAdapter[Any] = TypeAdapter(Command)

SPANS = {1: (0, 20), 2: (15, 40), 3: (50, 70)}
"""Engine tracks: first and last frame."""


def engine_box(track: int, frame: int) -> tuple[float, float, float, float] | None:
    """The engine's box of a toy track; every seventh frame is missing."""
    first, last = SPANS[track]
    if not first <= frame <= last or frame % 7 == 6:
        return None
    return (100.0 * track + frame, 10.0, 100.0 * track + frame + 20, 30.0)


def engine_gaps(track: int) -> list[tuple[int, int | None]]:
    """The frames of a toy track without a box, as the evidence gives them."""
    first, last = SPANS[track]
    ended = last if engine_box(track, last) else last - 1
    return [*((f, f) for f in range(first, ended) if engine_box(track, f) is None), (ended + 1, None)]


def initial_documents() -> dict[str, TrackDoc]:
    """Documents of the toy tracks before any edit."""
    return {f"m{t}": engine_doc(t, *span) for t, span in SPANS.items()}


def interrupted_lines(start: list[float], end: list[float]) -> list[dict[str, Any]]:
    """Commands for a line from frame 3 to 18 of m1, shown up to frame 8, and one from 20 to 35 of m2, shown from 27 on.

    A key frame without a box shows the engine's boxes in the other frames.
    """
    return [
        {"name": "set_box", "frame": 3, "key": "m1", "box": start},
        {"name": "set_box", "frame": 8, "key": "m1", "box": end},
        {"name": "interpolate", "frame": 3, "key": "m1", "first": 3, "last": 8, "value": True},
        {"name": "set_occluded", "frame": 9, "key": "m1", "value": True},
        {"name": "set_box", "frame": 18, "key": "m1", "box": end},
        {"name": "remove_key", "frame": 8, "key": "m1"},
        {"name": "set_occluded", "frame": 27, "key": "m2", "value": True},
        {"name": "set_box", "frame": 20, "key": "m2", "box": start},
        {"name": "set_box", "frame": 25, "key": "m2", "box": end},
        {"name": "set_box", "frame": 35, "key": "m2", "box": end},
        {"name": "interpolate", "frame": 25, "key": "m2", "first": 25, "last": 35, "value": True},
        {"name": "remove_key", "frame": 25, "key": "m2"},
    ]


def random_box(rng: random.Random) -> list[float]:
    """A box with edges that binary fractions hold exactly."""
    x, y = rng.randrange(0, 800) / 4, rng.randrange(0, 400) / 4
    return [x, y, x + rng.randrange(1, 99) / 2, y + rng.randrange(1, 99) / 2]


def random_follow_boxes(rng: random.Random) -> list[dict[str, Any]]:
    """Boxes of a followed track in frame order; one or two of them are anchors."""
    frames = sorted(rng.sample(range(75), rng.randrange(1, 6)))
    anchors = set(rng.sample(frames, min(len(frames), rng.choice([1, 1, 2]))))
    return [{"frame": frame, "box": random_box(rng), "anchor": frame in anchors} for frame in frames]


def random_command(rng: random.Random, docs: dict[str, TrackDoc], serial: int) -> dict[str, Any]:
    """A random command, not always valid."""
    alive = [key for key, doc in docs.items() if not doc.gone] or ["m1"]
    key = rng.choice(alive if rng.random() < 0.95 else [*docs, "m9"])
    frame = rng.randrange(0, 75)
    on: dict[str, Any] = {"frame": frame, "key": key}
    notes = [note.id for note in docs[key].notes] if key in docs else []
    note = rng.choice([*notes, "nowhere"])
    screen = {"box": random_box(rng)} if rng.random() < 0.5 else {}
    choices: list[dict[str, Any]] = [
        {"name": "create_track", "frame": frame, "key": f"hmade{serial:04d}", "box": random_box(rng), "class_id": 14},
        {"name": "set_box", **on, "box": random_box(rng)},
        {"name": "set_box", **on, "box": random_box(rng)},
        {"name": "add_key", **on, "box": random_box(rng)},
        {"name": "relabel_track", **on, "class_id": rng.choice([None, -1, 3, 42])},
        {"name": "relabel_box", **on, "class_id": rng.choice([None, -1, 7]), **screen},
        {"name": "merge", **on, "others": rng.sample(alive, min(len(alive), rng.choice([1, 2])))},
        {"name": "merge", **on, "others": [rng.choice(alive)]},
        {"name": "split", **on, "new_key": f"hpart{serial:04d}", "class_id": [None, 5, 38][serial % 3]},
        {"name": "delete_from", **on},
        {"name": "delete_track", **on},
        {"name": "restore_track", **on, "key": rng.choice([*docs, "m9"])},
        {"name": "remove_key", **on, "frame": rng.choice(docs[key].frames() or [frame]) if key in docs else frame},
        {"name": "interpolate", **on, "first": rng.randrange(0, 40), "last": rng.randrange(30, 75), "value": True},
        {"name": "interpolate", **on, "first": 0, "last": 74, "value": rng.random() < 0.5},
        {"name": "follow", **on, "boxes": random_follow_boxes(rng)},
        {"name": "follow", **on, "boxes": random_follow_boxes(rng)},
        {"name": "set_occluded", **on, "value": rng.random() < 0.7, **screen},
        {"name": "set_outside", **on, "value": rng.random() < 0.7, **screen},
        {"name": "set_not_a_sign", **on, "value": rng.random() < 0.5},
        {"name": "set_review", **on, "review": rng.choice(["open", "accepted", "rejected", "needs_work"])},
        {
            "name": "review_tracks",
            **on,
            "others": rng.sample([*alive, "m9"], 2),
            "review": rng.choice(["open", "accepted"]),
        },
        {"name": "add_note", **on, "note_id": f"n{serial}", "text": "<b>look</b>"},
        {"name": "edit_note", **on, "note_id": note, "text": "again"},
        {"name": "remove_note", **on, "note_id": note},
    ]
    return rng.choice(choices)


def random_attribute_command(rng: random.Random, docs: dict[str, TrackDoc], serial: int) -> dict[str, Any]:
    """A random command, often about attributes and ignored regions."""
    if rng.random() < 0.5:
        return random_command(rng, docs, serial)
    key, frame = rng.choice([key for key, doc in docs.items() if not doc.gone] or ["m1"]), rng.randrange(0, 75)
    on: dict[str, Any] = {"frame": rng.choice([frame, *docs[key].frames()]), "key": key}
    if rng.random() < 0.2:
        return {"name": "ignore", **on, "value": rng.random() < 0.6}
    choices: dict[str, list[Any]] = {"temporary": [True, False], "<b>": [1, 2.5], "__proto__": ["", "é 🚸"]}
    attribute, values = rng.choice(list(choices.items()))
    value = None if rng.random() < 0.2 else rng.choice(values)
    screen = {"box": random_box(rng)} if rng.random() < 0.3 else {}
    where: dict[str, Any] = {"from_here": True, **screen} if rng.random() < 0.7 else {}
    return {"name": "attribute", **on, "attribute": attribute, "value": value, **where}


def random_documents(seed: int, length: int) -> dict[str, TrackDoc]:
    """Documents of the toy tracks after some random commands."""
    rng, docs = random.Random(seed), initial_documents()
    for step in range(length):
        command = ADAPTER.validate_python(random_command(rng, docs, step))
        try:
            docs |= apply_command(docs, command)
        except CommandError:
            continue
    return docs
