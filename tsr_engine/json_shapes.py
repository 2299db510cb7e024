"""Types of JSON values that have the shape of a document, not of a class."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

JsonObject = dict[str, Any]  # Any: values of a JSON document
"""A JSON object whose keys depend on the version that wrote it: columns, messages, figures."""

JsonMapping = Mapping[str, Any]  # Any: values of a JSON document
"""A ``JsonObject`` that is only read."""
