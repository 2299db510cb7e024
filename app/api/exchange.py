"""Exports and imports: list formats, export by a job, import a streamed body."""

from __future__ import annotations

from typing import Annotated, TypeVar

from fastapi import Path, Query, Request
from pydantic import TypeAdapter, ValidationError

from app.api.access import WhoDep
from app.api.request_body import RAW_BODY, received_file, run_while_connected
from app.api.responses import failures
from app.api.routing import api_router
from app.api.runs import VideoId
from app.body_model import PLAIN, Model
from app.context import ContextDep
from app.errors import Invalid, file_error
from app.exchange.export import ExportRequest
from app.exchange.formats import FormatView, format_view
from app.exchange.import_file import ImportFile
from app.exchange.imports import ImportKind, ImportResult
from app.exchange.running_imports import ImportProgress
from app.outputs.view import OutputView
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.formats import UnknownNames
from tsr_engine.exchange.registry import FORMATS

_T = TypeVar("_T")

router = api_router("exchange")

ImportName = Annotated[str, Path(pattern="^[0-9a-f]{32}$", description="`progress` of the import request")]

_SWITCHES = TypeAdapter(dict[str, str])
_NAMES = TypeAdapter(list[str])
_LABELS = TypeAdapter(dict[str, int | str])


class Formats(Model):
    """All formats."""

    formats: list[FormatView]


@router.get("/formats", operation_id="list_formats", responses=failures())
def list_formats() -> Formats:
    """Formats that can be exported or imported, with their options."""
    return Formats(formats=[format_view(each) for each in FORMATS.values()])


@router.post("/exports", operation_id="start_export", status_code=202, responses=failures(404, 409))
def start_export(wanted: ExportRequest, context: ContextDep) -> OutputView:
    """Queue an export of one or more runs with their corrections, as one ZIP file."""
    return OutputView.from_row(context.exports.start(wanted))


@router.post(
    "/videos/{video_id}/imports",
    operation_id="import_file",
    status_code=201,
    responses=failures(404, 409),
    openapi_extra=RAW_BODY,
)
async def import_file(
    video_id: VideoId,
    request: Request,
    context: ContextDep,
    who: WhoDep,
    kind: Annotated[ImportKind, Query(alias="as", description="import as")],
    format: Annotated[str | None, Query(max_length=32, pattern=PLAIN, description="unset: detected")] = None,
    run: Annotated[str | None, Query(pattern="^[0-9a-f]{32}$", description="run to correct")] = None,
    name: Annotated[
        str, Query(min_length=1, max_length=120, pattern=r"^[^/\x00-\x1f\x7f]+$", description="file name, or a title")
    ] = "import",
    file: Annotated[
        str | None, Query(max_length=255, description="file name, if `name` is a title; its extension is used")
    ] = None,
    switches: Annotated[str, Query(max_length=4000, description='JSON: `{"option": "value"}`')] = "{}",
    label_map: Annotated[
        str, Query(max_length=200_000, description='JSON: `{"name in the file": number or key of a label, or -1}`')
    ] = "{}",
    unknown: Annotated[
        UnknownNames, Query(description="treatment of names that no label has; `add`: add them to the label set")
    ] = "refuse",
    add: Annotated[
        str,
        Query(max_length=200_000, description='JSON: `["name in the file"]`; added to the set whatever `unknown` is'),
    ] = "[]",
    author: Annotated[str | None, Query(min_length=1, max_length=80, pattern=PLAIN)] = None,
    progress: Annotated[
        str | None, Query(pattern="^[0-9a-f]{32}$", description="a name for this import, to read its progress")
    ] = None,
) -> ImportResult:
    """Read a file or ZIP archive and add it to the video. Either all of it is imported or nothing.

    Names that no label of the video's set has are refused with their list (code `unknown_labels`), unless `label_map`
    or `unknown` say how to treat them. `label_map` is remembered for the next file. A ground truth replaces one of the
    same name. An annotation is one operation of the run's log, so one undo reverts it.
    """
    person = who.author(author)
    options, labels = _json(_SWITCHES, switches, "switches"), _json(_LABELS, label_map, "label_map")
    async with received_file(request, context, file or name) as (path, work):
        names = _json(_NAMES, add, "add")
        upload = ImportFile(
            path=path,
            name=name,
            format=format,
            switches=options,
            label_map=labels,
            unknown=unknown,
            added=frozenset(names),
            author=person,
            scratch=work,
        )
        with context.running_imports.register(progress) as running:
            imports = context.sandboxed_imports
            try:
                return await run_while_connected(
                    request, lambda gone: imports.import_file(video_id, upload, kind, run, gone, running)
                )
            except ImportFormatError as error:
                raise file_error(str(error), error.kind) from None


@router.get("/imports/{name}", operation_id="get_import", responses=failures(404))
def get_import(name: ImportName, context: ContextDep) -> ImportProgress:
    """Progress of an import; 404 after it has ended. The import request itself returns the result."""
    return context.running_imports.progress(name)


@router.post("/imports/{name}/cancel", operation_id="cancel_import", status_code=202, responses=failures(404, 409))
def cancel_import(name: ImportName, context: ContextDep) -> None:
    """Cancel an import unless it is already being stored. The import request itself returns the result."""
    context.running_imports.cancel(name)


def _json(shape: TypeAdapter[_T], text: str, field: str) -> _T:
    try:
        return shape.validate_json(text, strict=True)
    except (ValidationError, ValueError):
        wanted = {"switches": 'object like {"option": "value"}', "label_map": 'object like {"name": "stop"}'}
        what = wanted.get(field, 'list like ["name"]')
        raise Invalid(f"{field} must be a JSON {what}. Got {text[:80]!r}.", field=field) from None
