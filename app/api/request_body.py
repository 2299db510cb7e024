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
from app.errors import Invalid, TooLarge, storage_full
from tsr_engine.json_shapes import JsonObject

RAW_BODY: Final[JsonObject] = {
    "requestBody": {
        "required": True,
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}
"""Entry of the OpenAPI document for a binary body."""
_CHECK_INTERVAL_S = 0.2
"""Seconds between checks whether the client is still connected."""
T = TypeVar("T")
_MAX_STEM_BYTES, _MAX_SUFFIX = 150, 16
"""Lengths of a file name without its extension, bytes, and of the extension: file systems allow 255 bytes in all."""
_UNSAFE = re.compile(r"[^\w .()+-]+")


def safe_name(name: str, otherwise: str) -> str:
    """Return a file name that is safe to use on this machine for a name that somebody else chose.

    A long name keeps its extension, which formats are detected by.
    """
    plain = _UNSAFE.sub("_", name).strip(" .")
    suffix = Path(plain).suffix if len(Path(plain).suffix) <= _MAX_SUFFIX else ""
    stem = plain.removesuffix(suffix).encode()[:_MAX_STEM_BYTES].decode(errors="ignore")
    return f"{stem}{suffix}" or otherwise


@asynccontextmanager
async def received_file(request: Request, context: Context, name: str) -> AsyncIterator[tuple[Path, Path]]:
    """Yield the body of a request as a file, and an empty folder to work in; both are removed when the block ends.

    The file lies in a separate folder, because its name may equal that of a file made on the way.

    Args:
        request: its body has not been read.
        context: gives the limit of uploads.
        name: the client's name for the file, used in messages.

    Raises:
        TooLarge, Invalid, StorageFull: see :func:`receive_body`.
    """
    part = await anyio.to_thread.run_sync(context.imports.new_part)
    try:
        sent, work = part / "sent", part / "work"
        sent.mkdir()
        work.mkdir()
        path = sent / safe_name(name, "import")
        await receive_body(request, path, context.settings.upload_max_mb * 2**20)
        yield path, work
    finally:
        with anyio.CancelScope(shield=True):
            await anyio.to_thread.run_sync(shutil.rmtree, part, True)  # ignores errors


async def run_while_connected(request: Request, work: Callable[[Callable[[], bool]], T]) -> T:
    """Run ``work`` in a thread and return its result; the thread can see whether the client has disconnected.

    Args:
        request: its body has been read.
        work: called with a function that returns whether to stop.
    """
    is_disconnected = threading.Event()

    async def watch() -> None:
        while not await request.is_disconnected():
            await asyncio.sleep(_CHECK_INTERVAL_S)
        is_disconnected.set()

    watcher = asyncio.get_running_loop().create_task(watch())
    try:
        return await anyio.to_thread.run_sync(work, is_disconnected.is_set)
    finally:
        is_disconnected.set()
        watcher.cancel()


async def receive_body(
    request: Request, path: Path, max_bytes: int, inspect: Callable[[bytes], None] | None = None
) -> None:
    """Write the body of a request to a new file and sync it to the disk.

    Args:
        request: its body has not been read.
        path: the file.
        max_bytes: maximum size, bytes.
        inspect: called with each piece before it is written; may raise.

    Raises:
        TooLarge: the body exceeds the limit.
        Invalid: the body is empty or incomplete.
        StorageFull: the disk is full, or the file would exceed the size limit of this process.
    """
    length = request.headers.get("content-length", "0")
    declared = int(length) if length.isascii() and length.isdigit() else 0
    if declared > max_bytes:
        raise TooLarge(f"The file has {declared} bytes; the limit is {max_bytes}.")
    size = 0
    try:
        with path.open("xb") as file:
            async for chunk in request.stream():
                size += len(chunk)
                if size > max_bytes:
                    raise TooLarge(f"The file has more than {max_bytes} bytes, which is the limit.")
                if inspect is not None:
                    inspect(chunk)
                await anyio.to_thread.run_sync(file.write, chunk)
            await anyio.to_thread.run_sync(_sync, file)
    except ClientDisconnect:
        raise Invalid("The upload was interrupted. Nothing was imported.", field="body", code="broken_off") from None
    except OSError as error:
        storage_error = storage_full(error)
        if storage_error is None:
            raise
        raise storage_error from None
    if not size:
        raise Invalid("The file is empty. Nothing was imported.", field="body")
    if 0 < declared != size:
        raise Invalid(f"The upload was interrupted after {size} of {declared} bytes.", field="body", code="broken_off")


def _sync(file: BinaryIO) -> None:
    file.flush()
    os.fsync(file.fileno())
