"""The two presets that ship: ``default`` measures best, ``paper`` follows the text.

A preset is a list of departures from the field defaults; ``default`` therefore is empty.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

PRESETS: MappingProxyType[str, MappingProxyType[str, Any]] = MappingProxyType(
    {
        "default": MappingProxyType({}),
        "paper": MappingProxyType({"motion": "paper", "fusion_mode": "scale"}),
    }
)
