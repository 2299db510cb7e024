"""Parameters from requests: the engine checks them; an error is one sentence."""

from __future__ import annotations

from collections.abc import Mapping

from app.errors import Invalid
from tsr_engine.errors import UsageError
from tsr_engine.json_shapes import JsonObject
from tsr_engine.params import Params
from tsr_engine.params.aliases import current_settings


def present_parameters(parameters: Mapping[str, object]) -> JsonObject:
    """Replace old names of parameters in a request by present ones.

    Raises:
        Invalid: a parameter is given by its old and by its present name.
    """
    try:
        return current_settings(parameters)
    except UsageError as error:
        raise Invalid(str(error), field="parameters") from None


def as_setting(value: object) -> object:
    """Convert a value of JSON to that of a parameter."""
    return tuple(value) if isinstance(value, list) else value


def params_of(preset: str, changed: Mapping[str, object]) -> Params:
    """Return a preset with changes.

    Raises:
        Invalid: no such preset or parameter, or a value out of range; ``field`` names it.
    """
    try:
        params = Params.preset(preset)
    except UsageError as error:
        raise Invalid(str(error), field="preset") from None
    for name, value in changed.items():
        try:
            params = params.with_settings([(name, as_setting(value))])
        except UsageError as error:
            raise Invalid(str(error), field=f"parameters.{name}") from None
    return params
