"""The checked request for a new model version."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field
from sqlalchemy.orm import Session

from app.body_model import PLAIN, Model
from app.errors import Conflict, Invalid, NotFound
from app.storage.lookup import ACTIVE
from app.storage.models import Output, Run, Video
from app.storage.servers import require_local
from app.videos.paths import allowed_path
from tsr_engine.json_shapes import JsonObject

OutputName = Annotated[str, Field(pattern="^[0-9a-f]{32}$")]
RunName = Annotated[str, Field(pattern="^[0-9a-f]{32}$")]


class Folders(Model):
    """Public data on this machine, inside the allowed folders."""

    gtsdb: str | None = Field(None, max_length=4096, pattern=PLAIN)
    gtsrb: str | None = Field(None, max_length=4096, pattern=PLAIN)


class NewModel(Model):
    """Sources of a new version."""

    name: str = Field("", max_length=120, pattern=PLAIN)
    parts: list[Literal["detector", "prior", "lambda", "classifier", "online"]] = Field(
        ["detector", "prior", "lambda", "classifier", "online"], min_length=1, max_length=5
    )
    reviews: list[RunName] = Field([], max_length=1000)
    """Runs of different videos; their corrections are read when training starts."""
    exports: list[OutputName] = Field([], max_length=100)
    """Ids of exports."""
    folders: Folders = Field(default_factory=Folders)
    seed: int = Field(0, ge=0, le=2**31 - 1)
    parent: str | None = Field(None, pattern="^([0-9a-f]{32}|shipped)$")
    """Version to start from; null: the active one."""


def public_folders(wanted: NewModel, roots: Sequence[Path]) -> dict[str, str]:
    """Return the folders of public data, by the name of the data.

    Raises:
        Invalid: there is nothing to learn from, or a path is not a folder.
        Refused: a folder lies outside the allowed ones.
    """
    folders = {name: _folder(path, name, roots) for name, path in wanted.folders.model_dump().items() if path}
    if not wanted.reviews and not wanted.exports and not folders:
        raise Invalid(
            "Name at least one reviewed run, one export of corrections, or folders of public data.", field="reviews"
        )
    return folders


def lineage_of(session: Session, wanted: NewModel, folders: dict[str, str]) -> JsonObject:
    """Return the part of a version's lineage that records the request.

    Raises:
        NotFound: no such run or export.
        Conflict: a run or an export is not complete.
        Invalid: two runs belong to one video.
    """
    exports = [_export(session, name) for name in dict.fromkeys(wanted.exports)]
    return {
        "parts": list(dict.fromkeys(wanted.parts)),
        "reviews": _reviews(session, list(dict.fromkeys(wanted.reviews))),
        "exports": [{"artefact": e.id, "name": e.name, "sha256": e.sha256, "options": e.options} for e in exports],
        "folders": folders,
        "seed": wanted.seed,
    }


def _folder(path: str, name: str, roots: Sequence[Path]) -> str:
    folder = allowed_path(path, roots)
    if not folder.is_dir():
        raise Invalid(f"There is no folder at {path}. Unpack the data there.", field=f"folders.{name}")
    return str(folder)


def _reviews(session: Session, runs: list[str]) -> list[JsonObject]:
    """Entries of the lineage for the requested reviews."""
    found: list[JsonObject] = []
    for run_id in runs:
        run = session.get(Run, run_id)
        if run is None:
            raise NotFound(f"There is no run {run_id!r}.", field="reviews")
        require_local(session, run.place, run.name)
        name = session.get_one(Video, run.video_id).name
        if run.state in ACTIVE:
            raise Conflict(f"The run of {name} is still {run.state}. Wait until it is complete.", code="still_running")
        if any(one["video"] == run.video_id for one in found):
            raise Invalid(f"Two of the runs belong to {name}. Choose one run per video.", field="reviews")
        found.append({"run": run_id, "video": run.video_id, "name": name})
    return found


def _export(session: Session, name: str) -> Output:
    output = session.get(Output, name)
    if output is None or output.kind != "export":
        raise NotFound(f"There is no export {name!r}.", field="exports")
    if output.state != "complete":
        raise Conflict(f"The export {output.name} is {output.state}. Wait until it is complete.", code="not_complete")
    require_local(session, output.place, output.name)
    return output
