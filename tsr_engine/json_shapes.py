"""Types of JSON values that have the shape of a document, not of a class."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["JsonMapping", "JsonObject"]

JsonObject = dict[str, Any]
"""An object of JSON whose shape is that of its writer, of this version or an older one: columns, messages, figures."""

JsonMapping = Mapping[str, Any]
"""The same where it is only read."""
