"""Errors of requests, and their JSON shape.

::

    ApiError                status
      Invalid               422   a value is wrong; ``field`` names it
      Unsafe                400   a file that does what only attacks do
      NotFound              404
      Refused               403   not allowed for this caller
      Conflict              409   outdated state; ``details`` holds both versions
      PreconditionRequired  428   If-Match is missing
      TooLarge              413
      UnsupportedMedia      415
      Busy                  503   try again
      OnOtherServer         503   the files are on another server of the database
      StorageFull           507   the disk is full, or a file exceeds a limit; see ``code``

Every answer of status 400 and above is ``{"error": {"code", "message", "field", "details"}}``.
"""

from __future__ import annotations

from typing import ClassVar, Final

from tsr_engine.errors import ImportProblem
from tsr_engine.io.storage_problems import TOO_LARGE_MESSAGE, full_disk_reason, storage_problem

RETRY_AFTER: Final = "2"
"""Seconds that a 503 asks to wait; a restart of a database takes about as long."""


class ApiError(Exception):
    """A request that cannot be served.

    Attributes:
        status: HTTP status.
        code: short word for programs.
        message: one sentence for people: expected, got, what to do.
        field: name of the wrong value, such as ``command.box``.
        details: further data for programs.
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
        """The JSON body of the response."""
        return error_body(self.code, self.message, self.field, self.details)


def error_body(
    code: str, message: str, field: str | None = None, details: dict[str, object] | None = None
) -> dict[str, object]:
    """Build the body of an error; lone surrogates in quoted text are replaced, because JSON cannot hold them."""
    reported = None if field is None else _whole(field)
    return {"error": {"code": code, "message": _whole(message), "field": reported, "details": details}}


def _whole(text: str) -> str:
    return text.encode("utf-8", "backslashreplace").decode()


class Invalid(ApiError):
    """A value of the request is wrong."""

    status, default_code = 422, "invalid"


class Unsafe(ApiError):
    """A file does what only attacks do."""

    status, default_code = 400, "unsafe"


class Unauthorised(ApiError):
    """A token is wrong or revoked."""

    status, default_code = 401, "unauthorised"


class NotFound(ApiError):
    """The requested thing does not exist."""

    status, default_code = 404, "not_found"


class Refused(ApiError):
    """Not allowed for this caller."""

    status, default_code = 403, "refused"


class Conflict(ApiError):
    """The request was made for an outdated state."""

    status, default_code = 409, "conflict"


class PreconditionRequired(ApiError):
    """A header that protects other people's work is missing."""

    status, default_code = 428, "precondition_required"


class TooLarge(ApiError):
    """The body exceeds the server's limit."""

    status, default_code = 413, "too_large"


class UnsupportedMedia(ApiError):
    """The route does not accept this kind of body."""

    status, default_code = 415, "unsupported_media"


class Busy(ApiError):
    """The request cannot be served at the moment."""

    status, default_code = 503, "busy"


class OnOtherServer(ApiError):
    """The files lie on another server; ``details`` names it."""

    status, default_code = 503, "elsewhere"


class StorageFull(ApiError):
    """No more data can be written."""

    status, default_code = 507, "storage_full"


def storage_full(error: OSError) -> StorageFull | None:
    """Convert an error of writing an imported file to a refusal if it means a lack of space; otherwise return None."""
    kind = storage_problem(error)
    if kind == "full":
        return StorageFull(
            f"{full_disk_reason(error).capitalize()}: nothing was imported. Free some space and try again."
        )
    return StorageFull(f"Nothing was imported: {TOO_LARGE_MESSAGE}.", code="storage_limit") if kind == "limit" else None


_ERROR_TYPES: Final[dict[ImportProblem, type[ApiError]]] = {"broken": Invalid, "too_large": TooLarge, "unsafe": Unsafe}


def file_error(sentence: str, kind: ImportProblem, code: str = "bad_file") -> ApiError:
    """Build the refusal of an imported file for a kind of problem."""
    return _ERROR_TYPES[kind](f"{sentence} Nothing was imported.", field="body", code=code)
