"""Parameters from outside: checked by the engine, told in one sentence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from app.errors import Invalid
from tsr_engine.errors import UsageError
from tsr_engine.params import Params

__all__ = ["params_of"]


def params_of(preset: str, changed: Mapping[str, Any]) -> Params:
    """A preset with changes.

    Raises:
        Invalid: no such preset or parameter, or a value out of range; ``field`` names it.
    """
    try:
        params = Params.preset(preset)
    except UsageError as error:
        raise Invalid(str(error), field="preset") from None
    for name, value in changed.items():
        plain = tuple(value) if isinstance(value, list) else value
        try:
            params = params.with_settings([(name, plain)])
        except UsageError as error:
            raise Invalid(str(error), field=f"parameters.{name}") from None
    return params
