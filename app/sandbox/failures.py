"""Failures of a sandbox: sent as JSON from inside, raised again outside."""

from __future__ import annotations

import logging
from typing import cast

from sqlalchemy.exc import DBAPIError

import app.errors as request_errors
import tsr_engine.errors as engine_errors
from app.errors import ApiError, storage_full
from app.storage.database import storage_failure
from tsr_engine.errors import ImportFormatError, ImportProblem, TsrError
from tsr_engine.json_shapes import JsonObject

_log = logging.getLogger("tsr.sandbox")


class SandboxError(TsrError):
    """A sandbox did not finish: it was killed, or exceeded a limit."""


def encode_failure(error: Exception) -> JsonObject:
    """Encode a failure for the other side; an unexpected one is also logged here."""
    if isinstance(error, DBAPIError):
        error = storage_failure(error) or error
    if isinstance(error, OSError):
        error = storage_full(error) or error
    if isinstance(error, ApiError):
        more = {"code": error.code, "field": error.field, "details": error.details}
        return {"request": type(error).__name__, "message": error.message, **more}
    if isinstance(error, ImportFormatError):
        return {"engine": "ImportFormatError", "message": str(error), "kind": error.kind}
    if isinstance(error, TsrError):
        # the other side knows only the classes of tsr_engine.errors: name the nearest base
        kind = next(base.__name__ for base in type(error).__mro__ if hasattr(engine_errors, base.__name__))
        return {"engine": kind, "message": str(error)}
    if isinstance(error, MemoryError):
        return {"memory": True}
    _log.error("A sandbox failed.", exc_info=error)
    return {"unexpected": type(error).__name__}


def decode_failure(failure: JsonObject, memory_mb: int) -> Exception:
    """Decode the failure that a sandbox reports; only our error classes are looked up, whatever name it sends."""
    message = str(failure.get("message", ""))
    if "request" in failure:
        kind = getattr(request_errors, str(failure["request"]), None)
        if isinstance(kind, type) and issubclass(kind, ApiError):
            code, field, details = (failure.get(name) for name in ("code", "field", "details"))
            return kind(message, code=code, field=field, details=details)
    if "engine" in failure:
        kind = getattr(engine_errors, str(failure["engine"]), None)
        if kind is ImportFormatError and failure.get("kind") in ("broken", "too_large", "unsafe"):
            return ImportFormatError(message, cast(ImportProblem, failure["kind"]))
        if isinstance(kind, type) and issubclass(kind, TsrError):
            return kind(message)
    if "memory" in failure:
        return SandboxError(f"it needs more than the {memory_mb} MiB of memory that it may use")
    return SandboxError(f"the process that read it failed ({str(failure.get('unexpected', 'unknown'))[:60]})")
