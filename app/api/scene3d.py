"""3-D views: their address, what they show, and export as a file."""

from __future__ import annotations

import secrets
from typing import Annotated

from fastapi import Query
from pydantic import Field

from app.api.responses import failures
from app.api.routing import api_router
from app.api.runs import RunId
from app.body_model import PLAIN, Model
from app.context import ContextDep
from app.outputs.view import OutputView
from app.scene3d.colours import Colouring
from app.scene3d.view_state import MODES, Mode

router = api_router("scene3d")

_VIEW = "^[0-9a-f]{8,32}$"
TrackKey = Annotated[str, Field(min_length=1, max_length=64, pattern=PLAIN)]


class Scene3dMode(Model):
    """One of the scenes."""

    id: Mode
    title: str


class Scene3d(Model):
    """Address of a view of the run."""

    url: str
    view: str
    modes: list[Scene3dMode]


class Cursor(Model):
    """State of the review screen; omitted fields stay as they are."""

    frame: int = Field(ge=0, le=2**31 - 1)
    track: TrackKey | None = Field(None, description="key of the selected track; null: none")
    view: str | None = Field(None, pattern=_VIEW, description="one view of the run; unset: all of them")
    mode: Mode | None = None


class Moved(Model):
    """Number of open views that were updated."""

    views: int


class NewScene(Model):
    """A scene to export as a file."""

    mode: Mode = "volume"
    frame: int | None = Field(None, ge=0, le=2**31 - 1, description="the cursor; unset: the run's first frame")
    track: TrackKey | None = None
    colour: Colouring = "class"
    stretch: float | None = Field(None, ge=0, le=86_400, description="seconds around the cursor; 0: the whole run")
    view: float = Field(60.0, ge=25, le=130, description="assumed horizontal field of view, degrees")
    size: float = Field(1.0, ge=0.5, le=1.5, description="assumed size of signs, against the catalogue's")
    name: str = Field("", max_length=120, pattern=PLAIN)


@router.get("/runs/{run_id}/scene3d", operation_id="get_scene3d", responses=failures(404, 409))
def get_scene3d(
    run_id: RunId,
    context: ContextDep,
    view: Annotated[str | None, Query(pattern=_VIEW, description="name of a view; unset: a new one")] = None,
) -> Scene3d:
    """The address of a 3-D view of the run. The view starts when it is opened."""
    context.scene3d.check(run_id)
    name = view or secrets.token_hex(8)
    modes = [Scene3dMode(id=mode, title=title) for mode, title in MODES.items()]
    return Scene3d(url=f"/viser/{run_id}/{name}", view=name, modes=modes)


@router.post("/runs/{run_id}/scene3d/cursor", operation_id="move_scene3d", responses=failures(404))
def move_scene3d(run_id: RunId, cursor: Cursor, context: ContextDep) -> Moved:
    """Move the cursor, the selection or the mode of open views. Among fast calls only the last one takes effect."""
    context.evidence.stored_run(run_id)
    changes: dict[str, object] = {"frame": cursor.frame}
    if "track" in cursor.model_fields_set:
        changes["track"] = cursor.track
    if cursor.mode is not None:
        changes["mode"] = cursor.mode
    return Moved(views=context.scene3d.move(run_id, cursor.view, **changes))


@router.post("/runs/{run_id}/scenes", operation_id="export_scene", status_code=202, responses=failures(404, 409))
def export_scene(run_id: RunId, wanted: NewScene, context: ContextDep) -> OutputView:
    """Export one scene as one HTML file that needs no server and no network."""
    return context.scenes.start(run_id, wanted.model_dump(mode="json", exclude={"name"}), wanted.name)
