"""Errors of requests, and their JSON shape.

::

    ApiError                status
      Invalid               422   a value is wrong; ``field`` names it
      Unsafe                400   a file that asks for what attacks ask for
      NotFound              404
      Refused               403   not allowed, whoever asks
      Conflict              409   somebody was faster; ``details`` holds both versions
      PreconditionRequired  428   If-Match is missing
      TooLarge              413
      UnsupportedMedia      415
      Busy                  503   try again
      Elsewhere             503   ask another server of the same database
      StorageFull           507   the disk is full, or a file may not grow; ``code`` tells which

Every answer of status 400 and above is ``{"error": {"code", "message", "field", "details"}}``.
"""

from __future__ import annotations

from typing import ClassVar, Final

from tsr_engine.errors import ImportProblem
from tsr_engine.io.storage_problems import TOO_LARGE, full_because, storage_problem

__all__ = [
    "RETRY_AFTER",
    "ApiError",
    "Busy",
    "Conflict",
    "Elsewhere",
    "Invalid",
    "NotFound",
    "PreconditionRequired",
    "Refused",
    "StorageFull",
    "TooLarge",
    "Unauthorised",
    "Unsafe",
    "UnsupportedMedia",
    "bad_file",
    "not_written",
]


RETRY_AFTER: Final = "2"
"""Seconds that a 503 asks to wait; a restart of a database takes about as long."""


class ApiError(Exception):
    """A request that cannot be served.

    Attributes:
        status: of HTTP.
        code: short word for programs.
        message: one sentence for people: expected, got, what to do.
        field: the value that is wrong, such as ``command.box``.
        details: what else a program needs.
    """

    status: ClassVar[int] = 500
    default_code: ClassVar[str] = "internal"

    def __init__(
        self,
        message: str,
        *,
        code: str | None = None,
        field: str | None = None,
        details: dict[str, object] | None = None,
    ) -> None:
        super().__init__(message)
        self.message = message
        self.code = code or self.default_code
        self.field = field
        self.details = details

    def body(self) -> dict[str, object]:
        """The JSON answer."""
        return error_body(self.code, self.message, self.field, self.details)


def error_body(
    code: str, message: str, field: str | None = None, details: dict[str, object] | None = None
) -> dict[str, object]:
    """The one shape of a failure; what is quoted from a request may hold halves of characters, which no JSON can."""
    reported = None if field is None else _whole(field)
    return {"error": {"code": code, "message": _whole(message), "field": reported, "details": details}}


def _whole(text: str) -> str:
    return text.encode("utf-8", "backslashreplace").decode()


class Invalid(ApiError):
    """A value of the request is wrong."""

    status, default_code = 422, "invalid"


class Unsafe(ApiError):
    """A file that tries what only attacks do."""

    status, default_code = 400, "unsafe"


class Unauthorised(ApiError):
    """A token is wrong or revoked."""

    status, default_code = 401, "unauthorised"


class NotFound(ApiError):
    """There is no such thing."""

    status, default_code = 404, "not_found"


class Refused(ApiError):
    """Not allowed, whoever asks."""

    status, default_code = 403, "refused"


class Conflict(ApiError):
    """The request was made for an outdated state."""

    status, default_code = 409, "conflict"


class PreconditionRequired(ApiError):
    """A header that protects others' work is missing."""

    status, default_code = 428, "precondition_required"


class TooLarge(ApiError):
    """The body is larger than the server takes."""

    status, default_code = 413, "too_large"


class UnsupportedMedia(ApiError):
    """The body is not what the route takes."""

    status, default_code = 415, "unsupported_media"


class Busy(ApiError):
    """Something is in the way for a moment."""

    status, default_code = 503, "busy"


class Elsewhere(ApiError):
    """The files lie with another server; ``details`` says which."""

    status, default_code = 503, "elsewhere"


class StorageFull(ApiError):
    """Nothing more can be written."""

    status, default_code = 507, "storage_full"


def not_written(error: OSError) -> StorageFull | None:
    """The answer where an imported file cannot be kept for want of room; None: it is something else."""
    kind = storage_problem(error)
    if kind == "full":
        return StorageFull(f"{full_because(error).capitalize()}: nothing was imported. Free some space and try again.")
    return StorageFull(f"Nothing was imported: {TOO_LARGE}.", code="storage_limit") if kind == "limit" else None


_OF_FILES: Final[dict[ImportProblem, type[ApiError]]] = {"broken": Invalid, "too_large": TooLarge, "unsafe": Unsafe}


def bad_file(sentence: str, kind: ImportProblem, code: str = "bad_file") -> ApiError:
    """The refusal of a file that somebody wanted to import, by what is wrong with it."""
    return _OF_FILES[kind](f"{sentence} Nothing was imported.", field="body", code=code)
