"""Base class of all request and response bodies."""

from __future__ import annotations

import ast
import inspect
import sys
from datetime import datetime
from functools import cache
from itertools import pairwise
from typing import Annotated, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from tsr_engine.json_shapes import JsonObject

PLAIN = r"^[^\x00]*$"
"""Pattern of texts that are stored in the database: no NUL, which PostgreSQL cannot hold."""

Moment = Annotated[str, BeforeValidator(lambda at: at.isoformat() if isinstance(at, datetime) else at)]
"""ISO 8601; takes a datetime."""


class Model(BaseModel):
    """Base of all bodies: refuses unknown fields and infinite numbers, and is immutable."""

    model_config = ConfigDict(
        extra="forbid", allow_inf_nan=False, frozen=True, json_schema_serialization_defaults_required=True
    )

    @classmethod
    def from_row(cls, row: object, /, **others: object) -> Self:
        """Make the view of a row; a field that is not in ``others`` is the row's attribute of the same name."""
        return cls(**{name: getattr(row, name) for name in cls.model_fields if name not in others}, **others)

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """The model's schema; in a response, fields that are omitted when empty are not required.

        The docstrings of fields are read here: ``use_attribute_docstrings`` reads them whenever a class is made, 0.3 s
        of each start, and few servers are asked for their schema.
        """
        schema = handler(core)
        plain = handler.resolve_ref_schema(schema)
        described = {name: text for kind in reversed(cls.__mro__) for name, text in _docstrings(kind).items()}
        for name, field in plain.get("properties", {}).items():
            if name in described:
                field.setdefault("description", described[name])
        if handler.mode == "serialization":
            absent = {name for name, field in cls.model_fields.items() if field.exclude_if is not None}
            plain["required"] = [name for name in plain.get("required", ()) if name not in absent]
        return schema


@cache
def _classes(module: str) -> dict[str, ast.ClassDef]:
    """The classes at the top of a module's source."""
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    return {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}


def _docstrings(kind: type) -> dict[str, str]:
    """The docstrings below the fields of a body's class."""
    node = _classes(kind.__module__).get(kind.__qualname__) if issubclass(kind, Model) else None
    found = {}
    for pair in pairwise(node.body if node else ()):
        match pair:
            case ast.AnnAssign(target=ast.Name(name)), ast.Expr(value=ast.Constant(str(text))):
                found[name] = inspect.cleandoc(text)
    return found


class ErrorDetail(Model):
    """One failure."""

    code: str
    message: str
    field: str | None
    details: JsonObject | None


class ErrorAnswer(Model):
    """The shape of every answer of status 400 and above."""

    error: ErrorDetail
