"""Renamed parameters. The old names of version 0.1 and 0.2 are understood for one more version, with a warning.

Runs, bundles and presets that name a parameter in the old way are read with the new name. The identity of a run is
computed with the names under which it was first stored, so runs of both versions resume and compare.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from tsr_engine.errors import UsageError
from tsr_engine.json_shapes import JsonMapping, JsonObject

__all__ = ["RENAMED", "present_name", "present_names", "present_sections", "rename_warnings", "stored_sections"]

RENAMED: Mapping[str, str] = MappingProxyType(
    {
        "detector.look_limit": "detector.refine_limit",
        "detector.outline_passes": "detector.refine_passes",
        "detector.tight_width": "detector.inset_width",
        "detector.tight_height": "detector.inset_height",
        "detector.tight_rise": "detector.inset_rise",
        "pipeline.sought_probability": "pipeline.search_probability",
        "pipeline.sought_noise": "pipeline.search_noise",
        "pipeline.sought_size_noise": "pipeline.search_size_noise",
        "pipeline.sought_sigmas": "pipeline.search_sigmas",
        "pipeline.closer_look": "pipeline.rescore_windows",
        "pipeline.closer_score": "pipeline.rescore_score",
        "pipeline.closer_noise": "pipeline.rescore_noise",
        "pipeline.refused_doubt": "pipeline.inflate_rejected_noise",
    }
)
"""Old name to present name; both belong to the same section."""

_LEAVES = {old.split(".")[1]: new.split(".")[1] for old, new in RENAMED.items()}
_FORMER = {new.split(".")[1]: old.split(".")[1] for old, new in RENAMED.items()}


def present_name(name: str) -> str:
    """The present name of a parameter, with its section if ``name`` has one; other names are returned unchanged."""
    return RENAMED.get(name) or _LEAVES.get(name, name)


def present_names(settings: JsonMapping) -> JsonObject:
    """Settings by present names.

    Raises:
        UsageError: a parameter is given by its old and by its present name.
    """
    found: JsonObject = {}
    for name, value in settings.items():
        present = present_name(name)
        if present != name and present in settings:
            raise UsageError(f"Parameter '{name}' is now called '{present}'. Set one of them, not both.")
        found[present] = value
    return found


def rename_warnings(names: Iterable[str]) -> list[str]:
    """One sentence for each name that is an old one."""
    return [
        f"Parameter '{name}' is now called '{present_name(name)}'. The old name is refused from the next version on."
        for name in names
        if present_name(name) != name
    ]


def present_sections(parameters: JsonMapping) -> JsonObject:
    """Stored parameters, section by section, with present names; anything else in them is left as it is."""
    return _with_leaves(parameters, _LEAVES)


def stored_sections(parameters: JsonMapping) -> JsonObject:
    """The reverse of :func:`present_sections`: the names that a run's identity is computed with."""
    return _with_leaves(parameters, _FORMER)


def _with_leaves(parameters: JsonMapping, leaves: Mapping[str, str]) -> JsonObject:
    return {
        section: {leaves.get(name, name): value for name, value in values.items()}
        if isinstance(values, Mapping)
        else values
        for section, values in parameters.items()
    }
