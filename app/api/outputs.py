"""Outputs: list, look at, download, cancel, remove."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import Path, Query
from fastapi.responses import FileResponse

from app.api.responses import failures
from app.api.routing import api_router
from app.body_model import Model
from app.context import ContextDep
from app.outputs.view import OutputView

router = api_router("outputs")

OutputId = Annotated[str, Path(pattern="^[0-9a-f]{32}$", description="name of the output: 32 hexadecimal digits")]
_FILE = {"content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}}}


class Outputs(Model):
    """Outputs, the newest first."""

    outputs: list[OutputView]


@router.get("/outputs", operation_id="list_outputs", responses=failures())
def list_outputs(
    context: ContextDep,
    kind: Annotated[Literal["export", "recording", "bundle", "scene"] | None, Query()] = None,
    run: Annotated[str | None, Query(pattern="^[0-9a-f]{32}$", description="made from this run alone")] = None,
) -> Outputs:
    """Files that were made from runs, and those in progress."""
    return Outputs(outputs=context.outputs.list(kind, run))


@router.get("/outputs/{output_id}", operation_id="get_output", responses=failures(404))
def get_output(output_id: OutputId, context: ContextDep) -> OutputView:
    """One output."""
    return OutputView.from_row(context.outputs.get(output_id))


@router.delete("/outputs/{output_id}", operation_id="remove_output", status_code=204, responses=failures(404, 409))
def remove_output(output_id: OutputId, context: ContextDep) -> None:
    """Remove an output and its file."""
    context.outputs.remove(output_id)


@router.post("/outputs/{output_id}/cancel", operation_id="cancel_output", status_code=202, responses=failures(404))
def cancel_output(output_id: OutputId, context: ContextDep) -> OutputView:
    """Cancel the making of an output; nothing of it is kept."""
    return OutputView.from_row(context.outputs.cancel(output_id))


@router.get(
    "/outputs/{output_id}/download",
    operation_id="download_output",
    response_class=FileResponse,
    responses={200: _FILE, 206: _FILE, **failures(404, 409, 416)},
)
def download_output(output_id: OutputId, context: ContextDep) -> FileResponse:
    """The file under its own name; supports ``Range``."""
    path, name = context.outputs.open(output_id)
    return FileResponse(
        path,
        filename=name,
        media_type="application/octet-stream",
        content_disposition_type="attachment",
        headers={"Content-Encoding": "identity"},  # parts of a file must be parts of the same bytes
    )
