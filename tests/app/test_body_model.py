"""The base of all bodies."""

from __future__ import annotations

from app.body_model import ErrorDetail, Model


class First(Model):
    """One body."""

    number: int
    """How many."""
    bare: int


class Second(First):
    """One that adds to it."""

    bare: int
    """Told here
    in two lines."""
    failure: ErrorDetail
    """A body in it."""


def test_the_schema_has_the_docstrings_of_fields() -> None:
    first, second = (
        {name: field.get("description") for name, field in kind.model_json_schema()["properties"].items()}
        for kind in (First, Second)
    )
    assert first == {"number": "How many.", "bare": None}
    assert second == {"number": "How many.", "bare": "Told here\nin two lines.", "failure": "A body in it."}
