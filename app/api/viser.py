"""The proxy of 3-D views: viser's page over HTTP, and its socket message by message.

:class:`app.security.guard.Guard` has checked token, Host and Origin before, for sockets and pages. A socket is
connected only to the port of the view in its address. Each direction forwards one message at a time and waits until it
is received, so a slow page slows viser down instead of filling this process.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Coroutine
from typing import TYPE_CHECKING, Annotated, Final, cast

from fastapi import Header, Path
from fastapi.responses import Response
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from app.api.responses import failures
from app.api.routing import api_router
from app.api.runs import RunId
from app.context import Context, ContextDep
from app.errors import ApiError
from app.scene3d.page import viser_page
from app.scene3d.view import View
from app.scene3d.viser_host import HEADER
from app.security.access import identity_of
from tsr_engine.errors import TsrError

if TYPE_CHECKING:
    from websockets.asyncio.client import ClientConnection

router = api_router(prefix="", in_schema=False)

ViewName = Annotated[str, Path(pattern="^[0-9a-f]{8,32}$", description="name that the page has given its view")]
_MAX_MESSAGE_BYTES: Final = 128 * 2**20
"""Maximum size of one message of viser, bytes; a scene comes in few, large messages."""
_MAX_QUEUED_MESSAGES: Final = 4
"""Messages of viser that are buffered until they are forwarded."""
ACCESS_CHECK_INTERVAL_S: Final = 2.0
"""Seconds between checks whether a socket's person still has access."""
_log = logging.getLogger("tsr.scene3d")


@router.get("/viser/{run_id}/{view}", responses=failures(404, 409))
@router.get("/viser/{run_id}/{view}/", responses=failures(404, 409))
def get_page(
    run_id: RunId,
    view: ViewName,
    context: ContextDep,
    accept_encoding: Annotated[str, Header()] = "",
    if_none_match: Annotated[str | None, Header()] = None,
) -> Response:
    """The page of viser; it loads its scene over the socket of the same address."""
    context.scene3d.check(run_id)
    page = viser_page()
    headers = {
        "ETag": page.etag,
        "Cache-Control": "private, no-cache",
        "Content-Security-Policy": page.policy,
        "Vary": "Accept-Encoding",
    }
    if if_none_match == page.etag:
        return Response(status_code=304, headers=headers)
    if "gzip" in accept_encoding:
        return Response(page.packed, media_type="text/html", headers={**headers, "Content-Encoding": "gzip"})
    return Response(page.content, media_type="text/html", headers={**headers, "Content-Encoding": "identity"})


@router.websocket("/viser/{run_id}/{view}")
@router.websocket("/viser/{run_id}/{view}/")
async def get_socket(socket: WebSocket, run_id: RunId, view: ViewName) -> None:
    """The socket of a view; opening it starts the view if needed."""
    context: Context = socket.app.state.context
    protocols = [p for p in socket.scope.get("subprotocols", []) if p.startswith("viser-v")]
    if not protocols:
        await socket.close(4400, "not viser's page")
        return
    try:
        view_3d = await asyncio.to_thread(context.scene3d.connect, run_id, view)
    except ApiError as error:
        await socket.close(4000 + error.status, error.code)
        return
    except TsrError:
        _log.exception("A 3-D view of run %s could not be opened.", run_id)
        await socket.close(4500, "internal")
        return
    try:
        await _connect(socket, view_3d, protocols[0])
    finally:
        context.scene3d.disconnect(view_3d)


async def _connect(socket: WebSocket, view: View, protocol: str) -> None:
    from websockets import Subprotocol, WebSocketException, connect  # of an extra

    try:
        async with connect(
            f"ws://127.0.0.1:{view.host.port}/",
            additional_headers={HEADER: view.host.secret},
            subprotocols=[Subprotocol(protocol)],
            compression=None,
            max_size=_MAX_MESSAGE_BYTES,
            max_queue=_MAX_QUEUED_MESSAGES,
            ping_interval=None,
            open_timeout=30,
            close_timeout=1,
            proxy=None,
        ) as upstream:
            await socket.accept(upstream.subprotocol)
            await _first_done(_to_page(upstream, socket), _to_viser(socket, upstream), wait_for_access_loss(socket))
    except (WebSocketException, OSError, WebSocketDisconnect, RuntimeError) as error:
        _log.debug("The socket of a 3-D view has ended: %s", error)
    if socket.application_state is not WebSocketState.DISCONNECTED:
        with contextlib.suppress(RuntimeError, WebSocketDisconnect):  # the page was faster
            await socket.close(1001, "the view has ended")


async def _first_done(*parts: Coroutine[object, object, None]) -> None:
    """Run both directions until one ends, then cancel the other."""
    tasks = [asyncio.ensure_future(part) for part in parts]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        for result in await asyncio.gather(*tasks, return_exceptions=True):
            if isinstance(result, Exception):
                _log.debug("One direction of a 3-D view's socket has ended: %r", result)


async def wait_for_access_loss(socket: WebSocket) -> None:
    """Return when the person who opened the view loses access to it."""
    access = cast(Context, socket.app.state.context).access
    while await access.has_access(identity_of(socket)):
        await asyncio.sleep(ACCESS_CHECK_INTERVAL_S)


async def _to_page(upstream: ClientConnection, socket: WebSocket) -> None:
    async for message in upstream:
        if isinstance(message, bytes):
            await socket.send_bytes(message)
        else:
            await socket.send_text(message)


async def _to_viser(socket: WebSocket, upstream: ClientConnection) -> None:
    while True:
        message = await socket.receive()
        if message["type"] == "websocket.disconnect":
            return
        content = message.get("bytes")
        await upstream.send(content if content is not None else message.get("text", ""))
