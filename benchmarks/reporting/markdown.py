"""Tables and figures as text of the report."""

from __future__ import annotations

from tsr_engine.json_shapes import JsonMapping
from tsr_engine.recognition.gtsrb_classes import SIGN_CLASSES


def table(rows: list[list[str]]) -> str:
    """A Markdown table; the first row is its head."""
    head, *body = rows
    lines = [head, ["---"] * len(head), *body]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def fraction(part: int, whole: int) -> str:
    """Two counts as one fraction."""
    return f"{part}/{whole}" if whole else "-"


def number(value: float | None, digits: int) -> str:
    """A figure, or a dash without a value."""
    return "-" if value is None else f"{value:.{digits}f}"


def short_number(value: float) -> str:
    """A count as it is, another figure with four decimals."""
    return str(value) if isinstance(value, int) else f"{value:.4f}"


def met(holds: bool) -> str:
    """The verdict on a bar."""
    return "met" if holds else "missed"


def change_text(change: JsonMapping | None) -> str:
    """A ``change`` with its interval ``low`` to ``high``, or a dash."""
    return "-" if change is None else f"{change['change']:+.4f} ({change['low']:+.4f} to {change['high']:+.4f})"


def class_name(class_id: int | None) -> str:
    """Name of a class of GTSRB."""
    return SIGN_CLASSES[class_id].name if class_id is not None and 0 <= class_id < len(SIGN_CLASSES) else "no class"
