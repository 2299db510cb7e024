"""Renamed parameters. The old names of version 0.1 and 0.2 are understood for one more version, with a warning.

Runs, bundles and presets that name a parameter in the old way are read with the new name. Where a switch has become a
choice, the old values are read as the choices that do the same. The identity of a run is computed with the names and
values under which it was first stored, so runs of both versions resume and compare.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType

from tsr_engine.errors import UsageError
from tsr_engine.json_shapes import JsonMapping, JsonObject

ALIASES: Mapping[str, str] = MappingProxyType(
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
        "pipeline.network_classifier": "pipeline.reader",
    }
)
"""Old name to present name; both belong to the same section."""
SWITCHES: Mapping[str, Mapping[bool, str]] = MappingProxyType(
    {"network_classifier": MappingProxyType({False: "classifier", True: "network"})}
)
"""Old name of a switch that is a choice today, without its section -> the choice for each of its values."""

_LEAVES = {old.split(".")[1]: new.split(".")[1] for old, new in ALIASES.items()}
_FORMER = {new.split(".")[1]: old.split(".")[1] for old, new in ALIASES.items()}
_OFF, _ON = frozenset({"false", "off", "no", "n", "f", "0"}), frozenset({"true", "on", "yes", "y", "t", "1"})
"""What a switch was called on the command line."""


def current_name(name: str) -> str:
    """The present name of a parameter, with its section if ``name`` has one; other names are returned unchanged."""
    return ALIASES.get(name) or _LEAVES.get(name, name)


def current_setting(name: str, value: object) -> tuple[str, object]:
    """The present name and value of a parameter; others are returned unchanged.

    Raises:
        UsageError: the old name of a switch with a value that is neither true nor false.
    """
    choices = SWITCHES.get(name.rpartition(".")[2])
    if choices is not None and current_name(name) != name:
        text = str(value).strip().lower()
        if text not in _ON | _OFF:
            raise UsageError(f"Parameter '{name}' is true or false. Got {value!r} instead.")
        value = choices[text in _ON]
    return current_name(name), value


def current_settings(settings: JsonMapping) -> JsonObject:
    """Settings by present names.

    Raises:
        UsageError: a parameter is given by its old and by its present name, or see :func:`current_setting`.
    """
    found: JsonObject = {}
    for name, value in settings.items():
        present, found_value = current_setting(name, value)
        if present != name and present in settings:
            raise UsageError(f"Parameter '{name}' is now called '{present}'. Set one of them, not both.")
        found[present] = found_value
    return found


def rename_warnings(names: Iterable[str]) -> list[str]:
    """One sentence for each name that is an old one."""
    return [
        f"Parameter '{name}' is now called '{current_name(name)}'{_choices(name)}. The old name is refused from the "
        "next version on."
        for name in names
        if current_name(name) != name
    ]


def _choices(name: str) -> str:
    """What the values of an old switch are called today."""
    choices = SWITCHES.get(name.rpartition(".")[2])
    return "" if choices is None else f" ('{choices[True]}' for true, '{choices[False]}' for false)"


def current_sections(parameters: JsonMapping) -> JsonObject:
    """Stored parameters, section by section, with present names; anything else in them is left as it is."""
    return _each(parameters, _present)


def stored_sections(parameters: JsonMapping) -> JsonObject:
    """The reverse of :func:`current_sections`: the names and values that a run's identity is computed with.

    A choice that the old switch did not have keeps its present name.
    """
    return _each(parameters, _stored)


def _each(parameters: JsonMapping, change: Callable[[str, object], tuple[str, object]]) -> JsonObject:
    return {
        section: dict(change(name, value) for name, value in values.items()) if isinstance(values, Mapping) else values
        for section, values in parameters.items()
    }


def _present(name: str, value: object) -> tuple[str, object]:
    choices = SWITCHES.get(name)
    return _LEAVES.get(name, name), choices[value] if choices is not None and isinstance(value, bool) else value


def _stored(name: str, value: object) -> tuple[str, object]:
    former = _FORMER.get(name, name)
    if former not in SWITCHES:
        return former, value
    before = [switch for switch, choice in SWITCHES[former].items() if choice == value]
    return (former, before[0]) if before else (name, value)
