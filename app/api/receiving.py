"""Bodies that are written to a file as they come."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import Any, Final

import anyio.to_thread
from fastapi import Request
from starlette.requests import ClientDisconnect

from app.errors import Invalid, StorageFull, TooLarge

__all__ = ["RAW_BODY", "receive"]

RAW_BODY: Final[dict[str, Any]] = {
    "requestBody": {
        "required": True,
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}
"""For the OpenAPI document."""


async def receive(request: Request, path: Path, most: int) -> None:
    """Write the body of a request to a new file.

    Args:
        request: its body has not been read.
        path: the file.
        most: bytes at most.

    Raises:
        TooLarge: over the limit.
        Invalid: empty, or broken off.
        StorageFull: the disk is full.
    """
    length = request.headers.get("content-length", "0")
    if length.isascii() and length.isdigit() and int(length) > most:
        raise TooLarge(f"The file has {length} bytes, allowed are {most}.")
    size = 0
    try:
        with path.open("xb") as file:
            async for chunk in request.stream():
                size += len(chunk)
                if size > most:
                    raise TooLarge(f"The file has more than {most} bytes.")
                await anyio.to_thread.run_sync(file.write, chunk)
    except ClientDisconnect:
        raise Invalid("The upload broke off. Nothing was imported.", field="body", code="broken_off") from None
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            raise StorageFull("The disk is full: nothing was imported. Free some space and try again.") from None
        raise
    if not size:
        raise Invalid("The file is empty. Nothing was imported.", field="body")
