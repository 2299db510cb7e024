"""Writes the page "About" of a recording: its content and its sources."""

from __future__ import annotations

from collections.abc import Mapping

from tsr_engine.evidence.header import RunHeader
from tsr_engine.recording.layers import LAYERS


def about_text(title: str, properties: Mapping[str, str], header: RunHeader, boxes: Mapping[str, int]) -> str:
    """The page in Markdown; names from files are in code spans, so that they are shown literally."""
    lines = [
        f"# {_plain(title)}",
        "",
        f"Picture: {_plain(properties['picture'])}",
        "",
        "| layer | boxes |",
        "|---|---|",
    ]
    lines += [f"| {LAYERS[name].title} | {count} |" for name, count in boxes.items()]
    lines += ["", "| | |", "|---|---|"]
    lines += [
        f"| {_plain(name.replace('_', ' '))} | {_code(value)} |"
        for name, value in properties.items()
        if name not in ("configuration", "models", "picture")
    ]
    lines += ["", "## Models", "", "| model | SHA-256 |", "|---|---|"]
    lines += [f"| {_plain(name)} | {_code(digest)} |" for name, digest in sorted(header.models.items())]
    lines += ["", "## Configuration", "", "| parameter | value |", "|---|---|"]
    for section, values in sorted(header.parameters.items()):
        inner = values.items() if isinstance(values, Mapping) else [("", values)]
        lines += [f"| {_plain(f'{section}.{name}'.rstrip('.'))} | {_code(str(value))} |" for name, value in inner]
    return "\n".join(lines) + "\n"


def _plain(text: str) -> str:
    return "".join(f"\\{c}" if c in "\\`*_[]<>|#" else " " if c in "\r\n" else c for c in text)


def _code(text: str) -> str:
    return "`" + text.replace("`", "'").replace("|", "/").replace("\n", " ").replace("\r", " ") + "`"
