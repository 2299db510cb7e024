"""Addresses of version 0.2, kept for one more version.

They are not in the OpenAPI document. Each answers as the present address does, with a ``Deprecation`` header and a
``Link`` to the present one.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Annotated, Final, Literal

from fastapi import Query, Request, Response
from fastapi.responses import FileResponse
from fastapi.routing import APIRoute

from app.api import ground_truths, outputs, scene3d
from app.api.ground_truths import GroundTruthView
from app.api.routing import api_router
from app.api.runs import VideoId
from app.body_model import Model
from app.context import ContextDep
from app.outputs.view import OutputView

DEPRECATED_SINCE: Final = "@1795651200"
"""2026-11-26 in the form of RFC 9745."""

_PRESENT: Final = (("/artefacts", "/outputs"), ("/truths", "/ground-truths"), ("/space", "/scene3d"))


class _FormerRoute(APIRoute):
    """A route whose responses all name its successor."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[object, object, Response]]:
        handle = super().get_route_handler()

        async def former(request: Request) -> Response:
            answer = await handle(request)
            present = request.url.path
            for old, new in _PRESENT:
                present = present.replace(old, new)
            answer.headers["Deprecation"] = DEPRECATED_SINCE
            answer.headers["Link"] = f'<{present}>; rel="successor-version"'
            return answer

        return former


router = api_router(in_schema=False, route_class=_FormerRoute)


class _Artefacts(Model):
    artefacts: list[OutputView]


class _Truths(Model):
    truths: list[GroundTruthView]


@router.get("/artefacts")
def list_artefacts(
    context: ContextDep,
    kind: Annotated[Literal["export", "recording", "bundle", "scene"] | None, Query()] = None,
    run: Annotated[str | None, Query(pattern="^[0-9a-f]{32}$")] = None,
) -> _Artefacts:
    """Outputs under their former key."""
    return _Artefacts(artefacts=outputs.list_outputs(context, kind, run).outputs)


@router.get("/videos/{video_id}/truths")
def list_truths(video_id: VideoId, context: ContextDep) -> _Truths:
    """Ground truths under their former key."""
    return _Truths(truths=ground_truths.list_ground_truths(video_id, context).ground_truths)


def _same(path: str, endpoint: Callable[..., object], method: str, status: int = 200) -> None:
    router.add_api_route(path, endpoint, methods=[method], status_code=status)


_same("/artefacts/{output_id}", outputs.get_output, "GET")
_same("/artefacts/{output_id}", outputs.remove_output, "DELETE", 204)
_same("/artefacts/{output_id}/cancel", outputs.cancel_output, "POST", 202)
router.add_api_route("/artefacts/{output_id}/download", outputs.download_output, response_class=FileResponse)
_same("/videos/{video_id}/truths/{name}", ground_truths.put_truth, "PUT", 201)
_same("/truths/{truth_id}/boxes", ground_truths.get_truth_boxes, "GET")
_same("/truths/{truth_id}", ground_truths.remove_truth, "DELETE", 204)
_same("/runs/{run_id}/space", scene3d.get_scene3d, "GET")
_same("/runs/{run_id}/space/cursor", scene3d.move_scene3d, "POST")
