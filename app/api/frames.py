"""Pictures, by ordinal."""

from __future__ import annotations

from typing import Annotated

from fastapi import Header, Path, Query
from fastapi.responses import Response

from app.api.old_addresses import DEPRECATED_SINCE
from app.api.responses import PICTURE, failures
from app.api.routing import api_router
from app.api.runs import VideoId
from app.context import ContextDep
from app.errors import Invalid
from app.evidence.crops import encode
from app.videos.decoding import Encoding

router = api_router("videos")

Edge = Annotated[int, Query(ge=0, le=2**20, description="edge of the part, px")]


@router.get(
    "/videos/{video_id}/frames/{ordinal}",
    operation_id="get_frame",
    response_class=Response,
    responses={200: PICTURE, 304: {"description": "unchanged"}, **failures(404, 409)},
)
def get_frame(
    video_id: VideoId,
    ordinal: Annotated[int, Path(ge=0, le=2**31 - 1)],
    context: ContextDep,
    width: Annotated[int | None, Query(ge=16, le=16384)] = None,
    encoding: Annotated[Encoding, Query(alias="format")] = "jpeg",
    preview: bool = False,
    glance: Annotated[bool, Query(include_in_schema=False)] = False,  # former name
    if_none_match: Annotated[str | None, Header()] = None,
) -> Response:
    """Frame k as the engine reads it. X-Frame-Ordinal and X-Frame-Pts identify it.

    With `preview`, a frame that takes long to decode may come as a small, soft picture, marked by
    `X-Frame-Exact: false`.
    """
    preview = preview or glance  # former name
    served = context.frames.picture(video_id, ordinal, width, encoding, _tags(if_none_match), preview=preview)
    headers = {
        "X-Frame-Exact": str(served.exact).lower(),
        "X-Frame-Ordinal": str(served.ordinal),
        "X-Frame-Pts": str(served.pts),
        "Content-Encoding": "identity",  # compressed already
    }
    if glance:  # former name
        headers["Deprecation"] = DEPRECATED_SINCE
    if served.exact:
        headers |= {"ETag": served.etag, "Cache-Control": "private, max-age=31536000, immutable"}
    else:
        headers["Cache-Control"] = "no-store"
    if served.data is None:
        return Response(status_code=304, headers=headers)
    return Response(served.data, media_type=f"image/{served.encoding}", headers=headers)


@router.get(
    "/videos/{video_id}/frames/{ordinal}/crop",
    operation_id="get_frame_crop",
    response_class=Response,
    responses={200: PICTURE, **failures(404, 409)},
)
def get_frame_crop(
    video_id: VideoId,
    ordinal: Annotated[int, Path(ge=0, le=2**31 - 1)],
    context: ContextDep,
    x1: Edge,
    y1: Edge,
    x2: Edge,
    y2: Edge,
    size: Annotated[int, Query(ge=16, le=512, description="longer side of the answer, px")] = 96,
) -> Response:
    """The part of frame k from pixel (x1, y1) up to, but excluding, (x2, y2), as PNG."""
    picture = context.frames.raw(video_id, ordinal)
    height, width = picture.shape[:2]
    if not (x1 < x2 <= width and y1 < y2 <= height):
        raise Invalid(
            f"The part must lie in the picture of {width}x{height} px and have an area. Got {x1}, {y1}, {x2}, {y2}.",
            field="x2",
        )
    headers = {"Cache-Control": "private, max-age=31536000, immutable"}
    return Response(encode(picture[y1:y2, x1:x2], size), media_type="image/png", headers=headers)


def _tags(header: str | None) -> frozenset[str]:
    """Return the ETags of an If-None-Match header. Weak ones count, as RFC 9110 defines for GET."""
    return frozenset(tag.strip().removeprefix("W/") for tag in (header or "").split(","))
