"""Writes a scene as one HTML file: viser's player, the scene, and a legend."""

from __future__ import annotations

import html
from collections.abc import Callable
from typing import TYPE_CHECKING

from app.scene3d.colours import legend_html
from app.scene3d.page import HUSH
from app.scene3d.scenes.base import Image, InitialView, SceneContext
from app.scene3d.view import SCENES, configure_server, place_viewers
from app.scene3d.view_state import ViewState
from app.scene3d.viser_host import ViserHost

if TYPE_CHECKING:
    import viser


def scene_html(
    context: Callable[[viser.SceneApi], SceneContext],
    picture: Callable[[int], Image | None],
    view_state: ViewState,
    title: str,
) -> str:
    """Draw one scene and export it as HTML.

    Args:
        context: makes the context for a scene API.
        picture: returns frame k as RGB; None: not available.
        view_state: state to draw.
        title: title of the page.
    """
    host = ViserHost(title)
    try:
        configure_server(host.server)
        scene = SCENES[view_state.mode](context(host.server.scene))
        look = scene.draw(view_state, None)
        scene.show(picture(view_state.frame))
        place_viewers(host.server, look)
        page: str = host.server.scene.as_html(dark_mode=True)
    finally:
        host.stop()
    return _finish(page, look, title)


def _finish(page: str, look: InitialView, title: str) -> str:
    """Set the page's title, block its network access, and add the legend."""
    policy = (
        "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval'; worker-src blob:; connect-src data: blob:; "
        "img-src data: blob:; style-src 'unsafe-inline'; font-src data:"
    )
    head = f'<meta http-equiv="Content-Security-Policy" content="{policy}" />'
    first = f'<meta charset="utf-8" />\n    {head}\n    <script>{HUSH}</script>'
    page = page.replace('<meta charset="utf-8" />', first, 1)
    page = page.replace("<title>Viser</title>", f"<title>{html.escape(title)}</title>", 1)
    legend = (
        '<div style="position:fixed;left:12px;bottom:12px;z-index:5;max-width:300px;padding:8px 0 2px;'
        'border-radius:8px;background:rgb(20 24 30/.86);color:#e7eaef;pointer-events:none">'
        f'<div style="font:600 13px/1.3 system-ui,sans-serif;padding:0 12px 6px">{html.escape(title)}</div>'
        f"{legend_html(look.title, look.legend, look.notes)}</div>"
    )
    at = page.rindex("</body>")
    return page[:at] + legend + page[at:]
