"""Labels with their pictures, and the sets that they belong to."""

from __future__ import annotations

import tempfile
from pathlib import Path as FilePath
from typing import Annotated, Literal

from fastapi import Body, Header, Path, Query
from fastapi.responses import Response
from pydantic import Field

from app.api.access import WhoDep
from app.api.edits import Author
from app.api.request_body import RAW_BODY, safe_name
from app.api.responses import CACHED_PNG, cached_png, failures
from app.api.routing import api_router
from app.api.runs import VideoId
from app.body_model import Model
from app.context import ContextDep
from app.errors import NotFound, file_error
from app.labels.commands import LabelChange
from app.labels.importing import import_file_labels
from app.labels.store import SET_KEY
from app.labels.views import Brought, Change, LabelSetView, LabelVersion, LabelView
from app.search.label_usage import LabelUsage, label_usage
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.label_files.formats import LABEL_FORMATS, read_labels, write_labels
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.files import dump_set
from tsr_engine.version import __version__

router = api_router("labels")

_SET: JsonObject = {"content": {"application/json": {"schema": {"type": "object"}}}}
_TEXT: JsonObject = {"schema": {"type": "string"}}
_FILE: JsonObject = {
    "content": {
        "application/json": {"schema": {}},
        **dict.fromkeys(("text/plain", "application/yaml", "application/xml"), _TEXT),
    }
}
_INDEX_WAIT_S = 1.0
"""Seconds to wait for tracks and edits that the search has not read yet."""
LabelFormatId = Literal["tsr", "cvat", "names", "yaml", "coco", "label-studio"]
SetKey = Annotated[str, Path(pattern=SET_KEY, description="key of the label set")]
_QueryKey = Annotated[
    str | None, Query(alias="set", pattern=SET_KEY, description="key of the label set; unset: the library's default")
]
LabelId = Annotated[int, Path(ge=0, le=2**31 - 1, description="id of the label")]
Version = Annotated[int | None, Query(ge=1, le=2**31 - 1, description="unset: the newest")]


class ChangeRequest(Model):
    """One change of one person."""

    author: Author | None = None
    change: LabelChange


class UseSet(Model):
    """The set to use from now on."""

    set: Annotated[str, Field(pattern=SET_KEY)]


class UseSetInVideo(Model):
    """The set that the video is to use; null: the library's default."""

    set: Annotated[str, Field(pattern=SET_KEY)] | None


@router.get("/labels", operation_id="list_labels", responses=failures(404))
def list_labels(
    context: ContextDep,
    video: Annotated[
        str | None, Query(pattern="^[0-9a-f]{64}$", description="labels of this video's set; unset: the library's")
    ] = None,
) -> list[LabelView]:
    """All labels in the order of the set, hidden and merged ones included."""
    return context.labels.labels(video)


@router.get(
    "/labels/{label_id}.png",
    operation_id="get_pictogram",
    response_class=Response,
    responses=failures(404) | CACHED_PNG,
)
def get_pictogram(
    label_id: LabelId,
    context: ContextDep,
    size: Annotated[int, Query(ge=8, le=512, description="side, px")] = 64,
    key: _QueryKey = None,
    look: Annotated[str | None, Query(max_length=64, description="changes with the picture; not read")] = None,
    if_none_match: Annotated[str | None, Header()] = None,
) -> Response:
    """The picture of a label: square, transparent around the sign."""
    label = context.labels.label(key, label_id)
    if not label.pictogram:
        raise NotFound(f"The label '{label.name}' has no picture.")
    tag = f"{__version__}-{label.pictogram}-{size}"
    try:
        return cached_png(lambda: context.pictograms.png(label.pictogram, size), tag, if_none_match, "max-age=86400")
    except KeyError:
        raise NotFound(f"The picture {label.pictogram!r} of the label '{label.name}' is missing.") from None


@router.get("/label-sets", operation_id="list_label_sets", responses=failures())
def list_label_sets(context: ContextDep) -> list[LabelSetView]:
    """All sets: those that ship with tsr, then the library's own."""
    return context.labels.sets()


@router.put("/label-sets/default", operation_id="use_label_set", responses=failures(404, 409))
def use_label_set(wanted: UseSet, context: ContextDep) -> LabelSetView:
    """Use this set for videos that name none."""
    return context.labels.use_as_default(wanted.set)


@router.get("/label-sets/{key}", operation_id="get_label_set", responses={**failures(404), 200: _SET})
def get_label_set(key: SetKey, context: ContextDep, version: Version = None) -> Response:
    """A set in tsr's own file format; see docs/label-set.schema.json."""
    return Response(dump_set(context.labels.get(key, version)), media_type="application/json")


@router.get("/label-sets/{key}/usage", operation_id="get_label_usage", responses=failures(404))
def get_label_usage(key: SetKey, context: ContextDep) -> LabelUsage:
    """Number of tracks with each label in the current run of each video."""
    context.search.update(_INDEX_WAIT_S)
    with context.database.read() as session:
        return label_usage(session, key, context.search.unread_current_runs())


@router.get("/label-sets/{key}/history", operation_id="list_label_versions", responses=failures(404))
def list_label_versions(key: SetKey, context: ContextDep) -> list[LabelVersion]:
    """Versions of a set, newest first: author, time and change."""
    return context.labels.history(key)


@router.get(
    "/label-sets/{key}/file",
    operation_id="get_label_file",
    response_class=Response,
    responses={**failures(404), 200: _FILE},
)
def get_label_file(
    key: SetKey, context: ContextDep, format: LabelFormatId = "tsr", version: Version = None
) -> Response:
    """A set in the format of another tool, for download."""
    chosen = LABEL_FORMATS[format]
    text = write_labels(context.labels.get(key, version), format)
    headers = {"Content-Disposition": f'attachment; filename="{key}-{chosen.file}"'}
    return Response(text, media_type=chosen.media, headers=headers)


@router.post(
    "/label-sets/{key}/files", operation_id="bring_label_file", responses=failures(404), openapi_extra=RAW_BODY
)
def bring_label_file(
    key: SetKey,
    context: ContextDep,
    who: WhoDep,
    content: Annotated[bytes, Body(media_type="application/octet-stream")],
    format: Annotated[LabelFormatId | None, Query(description="unset: detected")] = None,
    name: Annotated[
        str, Query(min_length=1, max_length=120, pattern=r"^[^/\x00-\x1f\x7f]+$", description="file name, for messages")
    ] = "labels",
    create: Annotated[bool, Query(description="make the set if no set has that key")] = False,
    author: Author | None = None,
) -> Brought:
    """Add the labels of a file that the set lacks. Existing labels keep their ids."""
    person = who.author(author)
    with tempfile.TemporaryDirectory() as folder:
        path = FilePath(folder) / safe_name(name, "labels")
        path.write_bytes(content)
        try:
            found = read_labels(path, key, name, format)
        except ImportFormatError as error:
            raise file_error(str(error), error.kind) from None
    return import_file_labels(context.labels, key, person, found, create=create, file=name)


@router.post("/label-sets/{key}/changes", operation_id="change_label_set", responses=failures(404, 409))
def change_label_set(key: SetKey, wanted: ChangeRequest, context: ContextDep, who: WhoDep) -> Change:
    """Change the newest version of a set."""
    return context.labels.change(key, who.author(wanted.author), wanted.change)


@router.put("/videos/{video_id}/label-set", operation_id="use_label_set_in_video", responses=failures(404, 409))
def use_label_set_in_video(video_id: VideoId, wanted: UseSetInVideo, context: ContextDep) -> LabelSetView:
    """Choose a video's label set. Returns the set that it uses now."""
    return context.labels.use_in_video(video_id, wanted.set)
