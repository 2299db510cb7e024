"""``tsr search``: the tracks of a whole library by label, uncertainty, state and more, without a server."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.library import HomeOption, open_library
from tsr_engine.cli.common import JsonOption, out_console, print_json, say
from tsr_engine.errors import UsageError

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

    from app.search.query import SearchAnswer, SearchRequest

_PAGE_SIZE = 500
_PROGRESS_INTERVAL_S = 5.0
"""Seconds between two reports of progress."""

Words = list[str]


def search(
    home: HomeOption = None,
    label: Annotated[
        Words, typer.Option("--label", help="Name or words of it, key, alias, short name or #number; repeatable.")
    ] = [],  # noqa: B006
    state: Annotated[
        Words, typer.Option("--state", help="open, needs_work, accepted, rejected or ignored; repeatable.")
    ] = [],  # noqa: B006
    uncertainty_min: Annotated[float | None, typer.Option("--uncertainty-min", help="0 to 1.")] = None,
    uncertainty_max: Annotated[float | None, typer.Option("--uncertainty-max", help="0 to 1.")] = None,
    size_min: Annotated[float | None, typer.Option("--size-min", help="Longer side of the largest box, px.")] = None,
    size_max: Annotated[float | None, typer.Option("--size-max", help="Longer side of the largest box, px.")] = None,
    attribute: Annotated[
        Words, typer.Option("--attribute", help="NAME=ANSWER, or NAME; repeatable, all must hold.")
    ] = [],  # noqa: B006
    author: Annotated[Words, typer.Option("--author", help="Who edited the track last; repeatable.")] = [],  # noqa: B006
    since: Annotated[str | None, typer.Option("--since", help="Last edit on this day or later, UTC.")] = None,
    until: Annotated[str | None, typer.Option("--until", help="Last edit on this day or earlier, UTC.")] = None,
    text: Annotated[str, typer.Option("--text", help="Words in the notes.")] = "",
    tag: Annotated[Words, typer.Option("--tag", help="Tag of the video; repeatable.")] = [],  # noqa: B006
    video: Annotated[str, typer.Option("--video", help="Words of the video's name, or its id.")] = "",
    all_runs: Annotated[bool, typer.Option("--all-runs", help="Include older runs of a video.")] = False,
    sort: Annotated[str, typer.Option("--sort", help="uncertainty, size or edited.")] = "uncertainty",
    ascending: Annotated[bool, typer.Option("--ascending", help="Smallest first.")] = False,
    limit: Annotated[int, typer.Option("--limit", min=1, help="Number of tracks to list.")] = 50,
    rebuild: Annotated[bool, typer.Option("--rebuild", help="Read all runs again first.")] = False,
    json: JsonOption = False,
) -> None:
    """Find tracks in all videos of a data folder.

    \b
    Examples:
      tsr search --label 60 --uncertainty-min 0.3
      tsr search --label pedestrian
      tsr search --state rejected --author ada --since 2026-11-01 --json
    """
    from pydantic import ValidationError

    from app.evidence.service import EvidenceService
    from app.search.index import SearchIndex
    from app.search.query import SearchRequest
    from tsr_engine.labels.name_matching import first_problem

    asked: dict[str, object] = {
        "label": label,
        "state": state,
        "uncertainty_min": uncertainty_min,
        "uncertainty_max": uncertainty_max,
        "size_min": size_min,
        "size_max": size_max,
        "attribute": attribute,
        "author": author,
        "since": since,
        "until": until,
        "text": text,
        "tag": tag,
        "video": video,
        "runs": "all" if all_runs else "current",
        "sort": sort,
        "order": "asc" if ascending else "desc",
        "limit": min(limit, _PAGE_SIZE),
    }
    try:
        request = SearchRequest.model_validate(asked)
    except ValidationError as error:
        place, problem = first_problem(error)
        raise UsageError(f"--{place.split('.')[0].replace('_', '-')}: {problem}.") from None
    with open_library(home) as (settings, database):
        evidence = EvidenceService(settings, database)
        try:
            SearchIndex(database, evidence).read_all(_ProgressPrinter(), rebuild=rebuild)
        finally:
            evidence.close()
        with database.read() as session:
            found = _pages(session, request, limit)
    if json:
        print_json(found.model_dump(mode="json", exclude={"next", "unread"}))
        return
    _print(found, label)


class _ProgressPrinter:
    """Prints now and then how many runs have been read."""

    def __init__(self) -> None:
        self._said = time.monotonic()

    def __call__(self, done: int, of: int) -> None:
        if time.monotonic() - self._said > _PROGRESS_INTERVAL_S:
            self._said = time.monotonic()
            say(f"Read {done} of {of} runs for the search.")


def _pages(session: Session, request: SearchRequest, limit: int) -> SearchAnswer:
    """All wanted tracks in one answer."""
    from app.search.query import answer

    found = answer(session, request, 0)
    tracks = list(found.tracks)
    while found.next is not None and len(tracks) < limit:
        rest = {"cursor": found.next, "limit": min(_PAGE_SIZE, limit - len(tracks))}
        found = answer(session, request.model_copy(update=rest), 0)
        tracks += found.tracks
    return found.model_copy(update={"tracks": tracks})


def _print(found: SearchAnswer, asked: Words) -> None:
    from rich.table import Table
    from rich.text import Text

    if found.tracks:
        table = Table(
            "video", "run", "track", "label", "state", "uncertainty", "px", "frame", "author", box=None, pad_edge=False
        )
        for each in found.tracks:
            words = (
                each.video_name,
                each.run_name,
                each.key,
                "" if each.label is None else each.label.name,
                each.state,
                f"{each.uncertainty:.2f}",
                f"{each.size:.0f}",
                str(each.frame),
                each.author or "",
            )
            table.add_row(*map(Text, words))
        out_console().print(table)
    names = dict.fromkeys(label.name for label in found.labels)
    if not {name.casefold() for name in names} <= {word.strip().casefold() for word in asked}:
        say(f"{'Label' if len(names) == 1 else 'Labels'}: {', '.join(names)}.")
    more = " or more" if found.more else ""
    listed = f", {len(found.tracks)} listed" if found.total > len(found.tracks) else ""
    say(f"{found.total}{more} {'track' if found.total == 1 else 'tracks'} found{listed}.")
    for lost in found.unreadable:
        say(f"{lost.run_name} of {lost.video_name} cannot be read and is missing: {lost.message}")
    if found.unreadable_count > len(found.unreadable):
        say(f"{found.unreadable_count - len(found.unreadable)} more runs cannot be read.")
