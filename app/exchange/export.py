"""Makes an export from a request, for the server, the command line and tests."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from app.body_model import PLAIN, Model
from app.edits.documents import Key
from app.exchange.dataset import Source, VideoInfo, dataset_of
from app.videos.checked_file import ChangedError
from tsr_engine.errors import ExportError, UsageError
from tsr_engine.exchange.export import CROP_FORMATS, export_dataset
from tsr_engine.exchange.filters import Filters, NotInSet, count_open_left_out, filter_dataset, with_left_out
from tsr_engine.exchange.formats import ExportOptions, Format
from tsr_engine.exchange.manifest import Manifest
from tsr_engine.exchange.registry import complete_switches, format_named
from tsr_engine.exchange.relabel import resolve_merged_labels
from tsr_engine.exchange.split import SUBSETS, Split, make_split
from tsr_engine.io.opened_file import VideoSource, open_source
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.matching import LabelFinder, unknown_label
from tsr_engine.labels.model import LabelSet
from tsr_engine.track_table import NO_CLASS

State = Literal["open", "edited", "accepted", "rejected", "needs_work"]
DEFAULT_STATES: tuple[State, ...] = ("edited", "accepted", "rejected")
"""Accepted tracks, and open ones that a person has edited, are exported as signs. Rejected tracks, and those that are
no sign, are exported as hard negatives, never as signs.
"""
RunName = Annotated[str, Field(pattern="^[0-9a-f]{32}$")]
LabelWord = Annotated[str, Field(min_length=1, max_length=200)]
_MAX_SKIPPED = 200
"""Maximum number of reasons in the summary; the manifest has all."""


class Shares(Model):
    """Shares of the boxes; they need not add up to 1."""

    train: Annotated[float, Field(ge=0, le=1000)] = 0.8
    val: Annotated[float, Field(ge=0, le=1000)] = 0.2
    test: Annotated[float, Field(ge=0, le=1000)] = 0.0


class ExportRequest(Model):
    """What to export, and how."""

    runs: Annotated[list[RunName], Field(min_length=1, max_length=1000)]
    """Runs of different videos."""
    format: Annotated[str, Field(max_length=32, pattern=PLAIN)]
    pictures: Literal["none", "annotated", "all"] = "none"
    states: Annotated[list[State], Field(min_length=1, max_length=5)] = Field(list(DEFAULT_STATES))
    """Review states to export. ``edited``: open tracks that a person has edited. ``rejected``: listed in the manifest
    as hard negatives.
    """
    labels: (
        Annotated[list[Annotated[str, Field(min_length=1, max_length=200)] | int], Field(max_length=5000)] | None
    ) = None
    """Keys or numbers of labels to export, -1: not in the set; null: all."""
    classes: Annotated[list[Annotated[int, Field(ge=-1, le=2**31 - 1)]], Field(max_length=5000)] | None = None
    """Labels by number, as in version 0.1."""
    not_in_set: NotInSet = "leave-out"
    """Treatment of signs without a label of the set: left out, regions to ignore, or a class of their own."""
    class_map: Literal["all", "used"] = "all"
    """Labels that the files declare: all of the set, or only exported ones."""
    min_side: Annotated[float, Field(ge=0, le=10_000)] | None = None
    """Minimum shorter side of a box, px; smaller boxes are left out."""
    first: Annotated[int, Field(ge=0, le=2**31 - 2)] = 0
    stop: Annotated[int, Field(ge=1, le=2**31 - 1)] | None = None
    """Frame after the last; null: to the end."""
    split: Shares | None = None
    split_by: Literal["sign", "video"] = "sign"
    balance_labels: bool = False
    """Give each side of the split every label with enough signs."""
    split_seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 0
    thin_px: Annotated[float, Field(ge=0, le=100)] = 0.5
    switches: Annotated[dict[str, Annotated[str, Field(max_length=64)]], Field(max_length=20)] = Field({})
    tracks: Annotated[dict[RunName, Annotated[list[Key], Field(max_length=5000)]], Field(max_length=1000)] | None = (
        Field(None, exclude_if=lambda value: value is None)
    )
    """Keys of the tracks to export, by run; a run without an entry exports none. Null: all tracks."""
    name: Annotated[str, Field(max_length=120, pattern=r"^[^/\\\x00-\x1f\x7f]*$")] = ""
    """File name without suffix; empty: made from the request."""


def check_request(request: ExportRequest) -> Format:
    """Check a request before its job is queued.

    Raises:
        UsageError: an unknown format or option, an empty range, or shares that are all 0.
        ExportError: the format can only be imported, needs pictures or has none.
    """
    chosen = format_named(request.format)
    if chosen.write is None:
        raise ExportError(f"{chosen.title} can be imported, not exported. Choose another format.")
    chosen.check_pictures(request.pictures)
    complete_switches(chosen, dict(request.switches), reading=False)
    if request.labels is not None and request.classes is not None:
        raise UsageError("'labels' and 'classes' choose the same thing. Give only one of them.")
    if request.not_in_set == "ignore" and not chosen.ignores:
        raise UsageError(
            f"{chosen.title} has no mark for regions to ignore. Leave signs that are not in the set out, or make them "
            "a class."
        )
    _filters(request, None)
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
        request: the request; its ``runs`` are ignored.
        sources: the runs.
        out: folder, or with ``zipped`` the file.
        zipped: write one ZIP file.
        progress: called with (done, total); raises to stop.

    Raises:
        UsageError: an option is invalid.
        ExportError: the format cannot hold the data, nothing is left to export, or a video for pictures is missing or
            was replaced.
        VideoError: a video cannot be read.
        StorageError: the disk is full.
    """
    chosen = check_request(request)
    full_dataset = every_track = dataset_of(sources)
    if request.tracks is not None:
        selected = request.tracks
        sources = [replace(source, keys=frozenset(selected.get(source.run_id or "", ()))) for source in sources]
        full_dataset = dataset_of(sources)
    filters = _filters(request, full_dataset.labels)
    dataset = filter_dataset(resolve_merged_labels(full_dataset), filters)
    if request.tracks is not None:
        dataset = with_left_out(dataset, every_track)
    if request.pictures != "none":
        for source in sources:
            _require_file(source)
    split: Split | None = None
    if request.split is not None:
        rule = "track" if chosen.name in CROP_FORMATS and request.split_by == "sign" else request.split_by
        shares = request.split.model_dump()
        split = make_split(dataset, shares, request.split_seed, rule, balance=request.balance_labels)
    options = ExportOptions(
        pictures=request.pictures,
        switches=dict(request.switches),
        thin_px=request.thin_px,
        split={} if split is None else split,
        used_labels=request.class_map == "used",
        progress=progress,
    )
    request_record = {
        **request.model_dump(mode="json", exclude={"name"}),
        "open_left": count_open_left_out(full_dataset, filters),
    }
    return export_dataset(dataset, chosen, out, options, zipped=zipped, about=request_record)


def summary_of(manifest: Manifest) -> JsonObject:
    """Summarise an export for pages: counts, and what was left out and why."""
    content = manifest.content
    return {
        "format": content["format"]["name"],
        "title": content["format"]["title"],
        "counts": manifest.counts,
        "split": {name: content["split"][name] for name in ("rule", "seed", "shares", "groups", "lacks")}
        | {"tracks": _subset_counts(content)},
        "videos": [
            {
                "name": video["name"],
                "sha256": video["sha256"],
                "run": video["provenance"].get("run", {}),
                "edit_revision": video["provenance"].get("edit_revision", 0),
            }
            for video in content["videos"]
        ],
        "open_left": content["asked"].get("open_left", 0),
        "files": len(manifest.files),
        "skipped": manifest.skipped[:_MAX_SKIPPED],
        "skipped_count": len(manifest.skipped),
    }


def _subset_counts(content: JsonObject) -> dict[str, int]:
    """Number of signs in each subset; empty without a split. Rejected tracks are no signs."""
    rejected = {(v["sha256"] or v["name"], track["id"]) for v in content["videos"] for track in v.get("negatives", ())}
    counts = Counter(subset for video, uid, subset in content["split"]["tracks"] if (video, uid) not in rejected)
    return {subset: counts[subset] for subset in SUBSETS if subset in counts}


def _require_file(source: Source) -> None:
    """Refuse a run whose video is missing although pictures are wanted; a changed file is read to compare its hash."""
    video = source.video
    if video.path is None:
        raise ExportError(
            f"The pictures of {video.name} cannot be read: its file is missing. Put it back, name it, or export "
            "without pictures."
        )
    if not _has_same_bytes(video.path, video):
        raise ExportError(
            f"{video.path} is not the video of {source.display_name}: that was {video.name} with the SHA-256 "
            f"{video.sha256[:12]}... . Put that file back, or export without pictures."
        )


def _has_same_bytes(path: VideoSource, video: VideoInfo) -> bool:
    """Whether a file has the video's bytes; a file of the library is compared when it is opened."""
    try:
        with open_source(path) as file:
            return not isinstance(path, Path) or video.known or file.sha256() == video.sha256
    except ChangedError:
        return False


def _label_ids(selected: str | int, labels: LabelSet) -> frozenset[int]:
    """Find labels by key, name or number; several are separated by commas.

    Raises:
        UsageError: the set has no such label.
    """
    if isinstance(selected, int):
        found = labels.get(selected)
        if found is None and selected != NO_CLASS:
            raise UsageError(unknown_label(str(selected), labels))
        return frozenset({labels.resolved(selected)})
    finder, parts, ids = LabelFinder(labels), selected.split(","), set[int]()
    while parts:
        # keys such as C,3a contain a comma
        for count in range(len(parts), 0, -1):
            word = ",".join(parts[:count]).strip()
            match = finder.find(word)
            if match is not None or word == str(NO_CLASS):
                ids.add(NO_CLASS if match is None else match.label.id)
                break
        else:
            raise UsageError(unknown_label(parts[0].strip(), labels))
        parts = parts[count:]
    return frozenset(ids)


def _includes_no_class(selected: Sequence[str | int] | None) -> bool:
    """Whether signs that are not in the set were chosen explicitly."""
    return selected is not None and any(str(NO_CLASS) in str(each).replace(" ", "").split(",") for each in selected)


def _filters(request: ExportRequest, labels: LabelSet | None) -> Filters:
    selected = request.classes if request.labels is None else request.labels
    ids = None
    if selected is not None and labels is not None:
        ids = frozenset[int]().union(*(_label_ids(each, labels) for each in selected))
    return Filters(
        states=frozenset(request.states),
        labels=ids,
        not_in_set="class" if _includes_no_class(selected) else request.not_in_set,
        min_side=request.min_side,
        first=request.first,
        stop=request.stop,
    )
