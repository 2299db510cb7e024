"""From what a person asks for to a finished export; the same for the server, the command line and tests."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from app.exchange.dataset import Source, VideoFacts, dataset_of
from app.shapes import PLAIN, Model
from app.videos.opened import ChangedError
from tsr_engine.errors import ExportError, UsageError
from tsr_engine.exchange.export import CROPS, export_dataset
from tsr_engine.exchange.filters import Filters, filtered
from tsr_engine.exchange.formats import ExportOptions, Format
from tsr_engine.exchange.manifest import Manifest
from tsr_engine.exchange.registry import format_named, switches_of
from tsr_engine.exchange.split import SUBSETS, Split, deal
from tsr_engine.io.opened_file import VideoSource, open_source

__all__ = ["DEFAULT_STATES", "ExportRequest", "Shares", "check_request", "export_sources", "summary_of"]

State = Literal["open", "accepted", "rejected", "needs_work"]
DEFAULT_STATES: tuple[State, ...] = ("open", "accepted", "needs_work", "rejected")
"""All. What people have rejected, or judged to be no sign, goes out as hard negatives: never as a sign."""
_MOST_SKIPPED = 200
"""Reasons kept in the summary; the manifest has all."""


class Shares(Model):
    """Shares of the boxes; they need not add up to 1."""

    train: Annotated[float, Field(ge=0, le=1000)] = 0.8
    val: Annotated[float, Field(ge=0, le=1000)] = 0.2
    test: Annotated[float, Field(ge=0, le=1000)] = 0.0


class ExportRequest(Model):
    """What to export, and how."""

    runs: Annotated[list[Annotated[str, Field(pattern="^[0-9a-f]{32}$")]], Field(min_length=1, max_length=1000)]
    """Of different videos."""
    format: Annotated[str, Field(max_length=32, pattern=PLAIN)]
    pictures: Literal["none", "annotated", "all"] = "none"
    states: Annotated[list[State], Field(min_length=1, max_length=4)] = Field(list(DEFAULT_STATES))
    """Review states that go out; ``rejected`` ones in the manifest, as what looks like a sign and is none."""
    classes: Annotated[list[Annotated[int, Field(ge=-1, le=42)]], Field(max_length=44)] | None = None
    """Class numbers, -1: unknown; null: all."""
    min_side: Annotated[float, Field(ge=0, le=10_000)] | None = None
    """Boxes whose shorter side is below stay here, px."""
    first: Annotated[int, Field(ge=0, le=2**31 - 2)] = 0
    stop: Annotated[int, Field(ge=1, le=2**31 - 1)] | None = None
    """Frame after the last; null: to the end."""
    split: Shares | None = None
    split_by: Literal["sign", "video"] = "sign"
    split_seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 0
    thin_px: Annotated[float, Field(ge=0, le=100)] = 0.5
    switches: Annotated[dict[str, Annotated[str, Field(max_length=64)]], Field(max_length=20)] = Field({})
    name: Annotated[str, Field(max_length=120, pattern=r"^[^/\\\x00-\x1f\x7f]*$")] = ""
    """File name without suffix; empty: made up."""


def check_request(request: ExportRequest) -> Format:
    """What can be told at once, before work is queued.

    Raises:
        UsageError: an unknown format or option, an empty range, shares that are all 0.
        ExportError: a format that is only read, or that needs pictures.
    """
    chosen = format_named(request.format)
    if chosen.write is None:
        raise ExportError(f"{chosen.title} can be imported, not exported. Choose another format.")
    if chosen.needs_pictures and request.pictures == "none":
        raise ExportError(f"{chosen.title} consists of pictures. Export with pictures of the annotated frames.")
    switches_of(chosen, dict(request.switches), reading=False)
    _filters(request)
    if request.split is not None and not any((request.split.train, request.split.val, request.split.test)):
        raise UsageError("The shares of the split are all 0. Give at least one of train, val and test a share.")
    return chosen


def export_sources(
    request: ExportRequest,
    sources: Sequence[Source],
    out: Path,
    *,
    zipped: bool,
    progress: Callable[[int, int], None] = lambda _done, _of: None,
) -> Manifest:
    """Write an export.

    Args:
        request: what was asked for; its ``runs`` are not looked at any more.
        sources: the runs.
        out: folder, or with ``zipped`` the file.
        zipped: one ZIP file.
        progress: told (done, of how many); raises to stop.

    Raises:
        UsageError: an option.
        ExportError: the format cannot hold the data, nothing is left, or pictures are wanted of a video whose file is
            not there or has become another.
        VideoError: that file cannot be read.
        StorageError: no room.
    """
    chosen = check_request(request)
    dataset = filtered(dataset_of(sources), _filters(request))
    if request.pictures != "none":
        for source in sources:
            _require_file(source)
    split: Split | None = None
    if request.split is not None:
        rule = "track" if chosen.name in CROPS and request.split_by == "sign" else request.split_by
        split = deal(dataset, request.split.model_dump(), request.split_seed, rule)
    options = ExportOptions(
        pictures=request.pictures,
        switches=dict(request.switches),
        thin_px=request.thin_px,
        split={} if split is None else split,
        progress=progress,
    )
    about = request.model_dump(mode="json", exclude={"name"})
    return export_dataset(dataset, chosen, out, options, zipped=zipped, about=about)


def summary_of(manifest: Manifest) -> dict[str, Any]:
    """What pages show of an export: counts, and what was left out why."""
    content: Mapping[str, Any] = manifest.content
    return {
        "format": content["format"]["name"],
        "title": content["format"]["title"],
        "counts": manifest.counts,
        "split": {name: content["split"][name] for name in ("rule", "seed", "shares", "groups")}
        | {"tracks": _fell(content)},
        "videos": [
            {
                "name": video["name"],
                "sha256": video["sha256"],
                "run": video["provenance"].get("run", {}),
                "edit_revision": video["provenance"].get("edit_revision", 0),
            }
            for video in content["videos"]
        ],
        "files": len(manifest.files),
        "skipped": manifest.skipped[:_MOST_SKIPPED],
        "skipped_count": len(manifest.skipped),
    }


def _fell(content: Mapping[str, Any]) -> dict[str, int]:
    """How many signs each subset got; empty without a split. What people rejected is none."""
    rejected = {(v["sha256"] or v["name"], one["id"]) for v in content["videos"] for one in v.get("negatives", ())}
    sides = Counter(side for video, uid, side in content["split"]["tracks"] if (video, uid) not in rejected)
    return {side: sides[side] for side in SUBSETS if side in sides}


def _require_file(source: Source) -> None:
    """Refuse a run whose video is not there for its pictures; the file is read where somebody has touched it."""
    video = source.video
    if video.path is None:
        raise ExportError(
            f"The pictures of {video.name} cannot be read: its file is not there. Put it back, name it, or export "
            "without pictures."
        )
    if not _is_the_file(video.path, video):
        raise ExportError(
            f"{video.path} is not the video of {source.called}: that was {video.name} with the SHA-256 "
            f"{video.sha256[:12]}... . Put that file back, or export without pictures."
        )


def _is_the_file(path: VideoSource, video: VideoFacts) -> bool:
    """Whether a file holds the video's bytes; one of the library is compared as it is opened."""
    try:
        with open_source(path) as file:
            return not isinstance(path, Path) or video.known or file.sha256() == video.sha256
    except ChangedError:
        return False


def _filters(request: ExportRequest) -> Filters:
    return Filters(
        states=frozenset(request.states),
        classes=None if request.classes is None else frozenset(request.classes),
        min_side=request.min_side,
        first=request.first,
        stop=request.stop,
    )
