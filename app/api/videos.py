"""Videos: add, list, look at, remove; folders to choose from."""

from __future__ import annotations

import hashlib
from typing import Annotated

import anyio.to_thread
from fastapi import Path, Query, Request
from fastapi.responses import FileResponse, Response
from pydantic import Field

from app.api.request_body import RAW_BODY, receive_body
from app.api.responses import PICTURE, failures
from app.api.routing import api_router
from app.api.runs import VideoId, forget_runs
from app.body_model import Model
from app.context import ContextDep
from app.errors import Invalid, NotFound, UnsupportedMedia
from app.search.filters import State
from app.search.matching import Matches, TrackQuery
from app.videos.checked_file import allowed_roots
from app.videos.packed_table import TableAnswer, page_table
from app.videos.paths import list_folder
from app.videos.view import VideoView
from tsr_engine.io.video_kinds import (
    MIN_HEAD_BYTES,
    PICTURE_SUFFIXES,
    VIDEO_SUFFIXES,
    cannot_be_video,
    not_a_video_message,
)

router = api_router("videos")


class NewVideo(Model):
    """A file on the server's machine."""

    path: str = Field(min_length=1, max_length=4096)


class Videos(Model):
    """All videos."""

    videos: list[VideoView]


class BrowseVideo(Model):
    """A video file in a folder."""

    name: str
    path: str
    size: int


class Browse(Model):
    """A folder."""

    path: str
    parent: str | None
    folders: list[str]
    videos: list[BrowseVideo]
    truncated: bool
    """There are more: these are the first by name."""


@router.get("/videos", operation_id="list_videos", response_model=Videos, responses=failures())
def list_videos(context: ContextDep) -> Response:
    """All videos, newest first."""
    return Response(context.videos.listing(), media_type="application/json")


@router.get("/videos/matching", operation_id="find_videos", responses=failures())
def find_videos(
    context: ContextDep,
    label: Annotated[
        str | None, Query(min_length=1, max_length=200, description="key, name or alias; -1: not in the set")
    ] = None,
    attribute: Annotated[str | None, Query(min_length=1, max_length=200, description="name of an attribute")] = None,
    value: Annotated[
        str | None, Query(max_length=1000, description="answer to it; unset: any that a person has given")
    ] = None,
    state: State | None = None,
) -> Matches:
    """Videos with a track that matches all filters, in the run that they open with and with people's corrections.

    Where `left` is above 0, some runs have not been counted yet: ask again.
    """
    if value is not None and attribute is None:
        raise Invalid("A value needs an attribute. Name it with 'attribute'.", field="attribute")
    return context.labelled_videos.find(TrackQuery(label, attribute, value, state))


@router.post("/videos", operation_id="add_video", status_code=201, responses=failures(404))
def add_video(wanted: NewVideo, context: ContextDep) -> VideoView:
    """Add a file of the server's machine by its path."""
    return context.videos.add_path(wanted.path)


@router.get("/videos/{video_id}", operation_id="get_video", responses=failures(404))
def get_video(video_id: VideoId, context: ContextDep) -> VideoView:
    """One video."""
    return context.videos.view(video_id)


@router.delete("/videos/{video_id}", operation_id="remove_video", status_code=204, responses=failures(404, 409))
def remove_video(video_id: VideoId, context: ContextDep) -> None:
    """Remove a video with its runs and edits. A file that was added by path is not deleted."""
    runs = context.videos.remove(video_id)
    context.frames.forget(video_id)
    forget_runs(context, runs)


@router.get("/videos/{video_id}/table", operation_id="get_frame_table", responses=failures(404, 409))
def get_frame_table(video_id: VideoId, context: ContextDep) -> TableAnswer:
    """The frames of the video and their presentation times."""
    return page_table(context.videos.table(video_id))


@router.get(
    "/videos/{video_id}/thumbnail",
    operation_id="get_thumbnail",
    response_class=FileResponse,
    responses={200: PICTURE, **failures(404)},
)
def get_thumbnail(video_id: VideoId, context: ContextDep) -> FileResponse:
    """A small picture from the middle of the video."""
    path = context.videos.thumbnail(video_id)
    if not path.is_file():
        raise NotFound("The video has no thumbnail yet.")
    return FileResponse(path, media_type="image/jpeg", headers={"Cache-Control": "private, max-age=86400"})


@router.get("/browse", operation_id="browse", responses=failures(404))
def browse(
    context: ContextDep, path: Annotated[str | None, Query(max_length=4096, description="unset: the first root")] = None
) -> Browse:
    """Folders and videos inside the allowed folders."""
    roots = allowed_roots(context.settings)
    listing = list_folder(path if path is not None else str(roots[0]), roots)
    return Browse(
        path=str(listing.path),
        parent=None if listing.parent is None else str(listing.parent),
        folders=listing.folders,
        videos=[BrowseVideo(name=name, path=str(path), size=size) for name, path, size in listing.videos],
        truncated=listing.truncated,
    )


@router.put(
    "/uploads/{name}", operation_id="upload_video", status_code=201, responses=failures(415), openapi_extra=RAW_BODY
)
async def upload_video(
    name: Annotated[str, Path(min_length=1, max_length=255)], request: Request, context: ContextDep
) -> VideoView:
    """Add a video by uploading its bytes, which are written as they arrive."""
    extensions = (*VIDEO_SUFFIXES, *PICTURE_SUFFIXES)
    if not name.lower().endswith(extensions):
        raise UnsupportedMedia(f"{name!r} has no file extension of a video ({', '.join(extensions)}).")
    if "/" in name or "\\" in name or not name.isprintable() or name.startswith("."):
        raise Invalid("The name of an upload must be a plain file name, without folders.", field="name")
    digest = hashlib.sha256()
    is_checked = False

    def inspect(chunk: bytes) -> None:
        nonlocal is_checked
        if not is_checked and len(chunk) >= MIN_HEAD_BYTES and cannot_be_video(chunk):
            raise UnsupportedMedia(not_a_video_message(name, chunk))
        is_checked = True
        digest.update(chunk)

    part = context.uploads.new_part()
    try:
        await receive_body(request, part, context.settings.upload_max_mb * 2**20, inspect)
        return await anyio.to_thread.run_sync(context.videos.add_upload, part, name, digest.hexdigest())
    finally:
        part.unlink(missing_ok=True)
