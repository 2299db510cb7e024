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
"""For the OpenAPI document."""
_LOOK = 0.2
"""Seconds between two looks at whether a client is still there."""
T = TypeVar("T")
_UNSAFE = re.compile(r"[^\w .()+-]+")


def safe_name(name: str, otherwise: str) -> str:
    """What a file is called here whose name somebody else has chosen."""
    return _UNSAFE.sub("_", name).strip(" .")[:100] or otherwise


@asynccontextmanager
async def received(request: Request, context: Context, name: str) -> AsyncIterator[tuple[Path, Path]]:
    """The body of a request as a file, and an empty folder to work in; both go when the block ends.

    The file has a folder of its own: a person may call it like anything that is made on the way.

    Args:
        request: its body has not been read.
        context: knows the limit of uploads.
        name: what the person calls the file; messages of readers call it so.

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
            await anyio.to_thread.run_sync(_remove, part)


async def while_there(request: Request, work: Callable[[Callable[[], bool]], T]) -> T:
    """What ``work`` returns, done by a thread; it is informed when the client has left.

    Args:
        request: its body has been read.
        work: called with what says whether to stop.
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
    """Write the body of a request to a new file, safe on the disk when this returns.

    Args:
        request: its body has not been read.
        path: the file.
        most: bytes at most.
        look: called with each piece before it is written; may raise.

    Raises:
        TooLarge: over the limit.
        Invalid: empty, or broken off.
        StorageFull: the disk is full, or the file may not grow so large.
    """
    length = request.headers.get("content-length", "0")
    announced = int(length) if length.isascii() and length.isdigit() else 0
    if announced > most:
        raise TooLarge(f"The file has {announced} bytes, allowed are {most}.")
    size = 0
    try:
        with path.open("xb") as file:
            async for chunk in request.stream():
                size += len(chunk)
                if size > most:
                    raise TooLarge(f"The file has more than {most} bytes.")
                if look is not None:
                    look(chunk)
                await anyio.to_thread.run_sync(file.write, chunk)
            await anyio.to_thread.run_sync(_settle, file)
    except ClientDisconnect:
        raise Invalid("The upload broke off. Nothing was imported.", field="body", code="broken_off") from None
    except OSError as error:
        full = not_written(error)
        if full is None:
            raise
        raise full from None
    if not size:
        raise Invalid("The file is empty. Nothing was imported.", field="body")
    if 0 < announced != size:
        raise Invalid(f"The upload broke off: {size} of {announced} bytes came.", field="body", code="broken_off")


def _settle(file: BinaryIO) -> None:
    file.flush()
    os.fsync(file.fileno())


def _remove(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
