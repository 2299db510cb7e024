"""Streams request bodies to files."""

from __future__ import annotations

import asyncio
import os
import re
import shutil
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import BinaryIO, Final, TypeVar

import anyio
import anyio.to_thread
from fastapi import Request
from starlette.requests import ClientDisconnect

from app.context import Context
from app.errors import Invalid, TooLarge, not_written
from tsr_engine.json_shapes import JsonObject

__all__ = ["RAW_BODY", "receive", "received", "safe_name", "while_there"]

RAW_BODY: Final[JsonObject] = {
    "requestBody": {
        "required": True,
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}
"""Entry of the OpenAPI document for a binary body."""
_LOOK = 0.2
"""Seconds between checks whether the client is still connected."""
T = TypeVar("T")
_UNSAFE = re.compile(r"[^\w .()+-]+")


def safe_name(name: str, otherwise: str) -> str:
    """Return a file name that is safe to use on this machine for a name that somebody else chose."""
    return _UNSAFE.sub("_", name).strip(" .")[:100] or otherwise


@asynccontextmanager
async def received(request: Request, context: Context, name: str) -> AsyncIterator[tuple[Path, Path]]:
    """Yield the body of a request as a file, and an empty folder to work in; both are removed when the block ends.

    The file lies in a separate folder, because its name may equal that of a file made on the way.

    Args:
        request: its body has not been read.
        context: gives the limit of uploads.
        name: the client's name for the file, used in messages.

    Raises:
        TooLarge, Invalid, StorageFull: see :func:`receive`.
    """
    part = await anyio.to_thread.run_sync(context.imports.new_part)
    try:
        sent, work = part / "sent", part / "work"
        sent.mkdir()
        work.mkdir()
        path = sent / safe_name(name, "import")
        await receive(request, path, context.settings.upload_max_mb * 2**20)
        yield path, work
    finally:
        with anyio.CancelScope(shield=True):
            await anyio.to_thread.run_sync(shutil.rmtree, part, True)  # ignores errors


async def while_there(request: Request, work: Callable[[Callable[[], bool]], T]) -> T:
    """Run ``work`` in a thread and return its result; the thread can see whether the client has disconnected.

    Args:
        request: its body has been read.
        work: called with a function that returns whether to stop.
    """
    left = threading.Event()

    async def watch() -> None:
        while not await request.is_disconnected():
            await asyncio.sleep(_LOOK)
        left.set()

    watching = asyncio.get_running_loop().create_task(watch())
    try:
        return await anyio.to_thread.run_sync(work, left.is_set)
    finally:
        left.set()
        watching.cancel()


async def receive(request: Request, path: Path, most: int, look: Callable[[bytes], None] | None = None) -> None:
    """Write the body of a request to a new file and sync it to the disk.

    Args:
        request: its body has not been read.
        path: the file.
        most: maximum size, bytes.
        look: called with each piece before it is written; may raise.

    Raises:
        TooLarge: the body exceeds the limit.
        Invalid: the body is empty or incomplete.
        StorageFull: the disk is full, or the file would exceed the size limit of this process.
    """
    length = request.headers.get("content-length", "0")
    announced = int(length) if length.isascii() and length.isdigit() else 0
    if announced > most:
        raise TooLarge(f"The file has {announced} bytes; the limit is {most}.")
    size = 0
    try:
        with path.open("xb") as file:
            async for chunk in request.stream():
                size += len(chunk)
                if size > most:
                    raise TooLarge(f"The file has more than {most} bytes, which is the limit.")
                if look is not None:
                    look(chunk)
                await anyio.to_thread.run_sync(file.write, chunk)
            await anyio.to_thread.run_sync(_settle, file)
    except ClientDisconnect:
        raise Invalid("The upload was interrupted. Nothing was imported.", field="body", code="broken_off") from None
    except OSError as error:
        full = not_written(error)
        if full is None:
            raise
        raise full from None
    if not size:
        raise Invalid("The file is empty. Nothing was imported.", field="body")
    if 0 < announced != size:
        raise Invalid(f"The upload was interrupted after {size} of {announced} bytes.", field="body", code="broken_off")


def _settle(file: BinaryIO) -> None:
    file.flush()
    os.fsync(file.fileno())
