"""Base class of all request and response bodies."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from tsr_engine.json_shapes import JsonObject

__all__ = ["PLAIN", "ErrorAnswer", "ErrorDetail", "Model", "Moment"]

PLAIN = r"^[^\x00]*$"
"""Pattern of texts that are stored in the database: no NUL, which PostgreSQL cannot hold."""

Moment = Annotated[str, BeforeValidator(lambda at: at.isoformat() if isinstance(at, datetime) else at)]
"""ISO 8601; takes a datetime."""


class Model(BaseModel):
    """Base of all bodies: refuses unknown fields and infinite numbers, and is immutable."""

    model_config = ConfigDict(
        extra="forbid",
        allow_inf_nan=False,
        frozen=True,
        use_attribute_docstrings=True,
        json_schema_serialization_defaults_required=True,
    )

    @classmethod
    def from_row(cls, row: object, /, **others: Any) -> Self:
        """Make the view of a row; a field that is not in ``others`` is the row's attribute of the same name."""
        return cls(**{name: getattr(row, name) for name in cls.model_fields if name not in others}, **others)

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """The model's schema; in a response, fields that are omitted when empty are not required."""
        schema = handler(core)
        if handler.mode == "serialization":
            plain = handler.resolve_ref_schema(schema)
            absent = {name for name, field in cls.model_fields.items() if field.exclude_if is not None}
            plain["required"] = [name for name in plain.get("required", ()) if name not in absent]
        return schema


class ErrorDetail(Model):
    """One failure."""

    code: str
    message: str
    field: str | None
    details: JsonObject | None


class ErrorAnswer(Model):
    """The shape of every answer of status 400 and above."""

    error: ErrorDetail
