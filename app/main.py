"""``create_app(settings)``: the whole server as one ASGI application."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import Depends, FastAPI
from starlette.middleware.gzip import GZipMiddleware

from app import rerun_pages
from app.api import (
    bundles,
    catalogue,
    compare,
    edits,
    events,
    evidence,
    exchange,
    follows,
    frames,
    ground_truths,
    labels,
    models,
    old_addresses,
    outputs,
    people,
    recordings,
    runs,
    scene3d,
    search,
    second_opinions,
    session,
    videos,
    viser,
)
from app.api.access import authorise
from app.context import build_context
from app.failures import ErrorShape, handle_failures
from app.login import mount_login
from app.pages import mount_pages
from app.security.guard import Guard
from app.settings import Settings
from app.startup import start, stop
from tsr_engine.version import __version__

# most requested first: each request searches its route in this order
_ROUTERS = (
    edits, evidence, frames, session, catalogue, labels, search, videos, runs, events, people, second_opinions,
    follows, ground_truths, compare, outputs, exchange, models, recordings, bundles, scene3d, old_addresses,
    rerun_pages, viser,
)  # fmt: skip


def create_app(settings: Settings) -> FastAPI:
    """Build the server.

    Raises:
        StorageError: the data folder or the database cannot be used.
    """
    context = build_context(settings)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        running = start(context)
        app.state.running = running
        try:
            yield
        finally:
            await stop(running)
            context.close()

    app = FastAPI(
        title="tsr review",
        version=__version__,
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        openapi_url="/api/openapi.json",
        redirect_slashes=False,
        dependencies=[Depends(authorise)],
    )
    app.state.context = context
    # not include_router, which builds each route again
    app.router.routes.extend(route for module in _ROUTERS for route in module.router.routes)
    mount_login(app, context.access)
    mount_pages(app)
    handle_failures(app)
    app.add_middleware(GZipMiddleware, minimum_size=2048, compresslevel=3)
    app.add_middleware(ErrorShape)
    app.add_middleware(Guard, access=context.access, hosts=settings.hosts, body_max=settings.body_max_kb * 1024)
    return app
