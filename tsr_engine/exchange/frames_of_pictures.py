"""Finds the pictures of an import that belong to its video, and the frame of each.

The names are judged together. Pictures form rows with the same folder and the same text before the number. Rows that
name the video are taken; the others are left out and reported. If no row names it, a single row is taken, and
reported if it names another video; several are refused. Each row counts from 0 or from 1 as a whole.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.checks import ImportValidator
from tsr_engine.exchange.counting import origin_of
from tsr_engine.exchange.dataset import DatasetVideo
from tsr_engine.exchange.picture_names import SHAPES
from tsr_engine.exchange.picture_rows import Listed, Nameless, Row, rows_of
from tsr_engine.exchange.reading import place_of, refuse
from tsr_engine.exchange.roboflow import refuse_changed_pictures
from tsr_engine.exchange.spellings import plain_name
from tsr_engine.plural import plural

__all__ = ["frames_of_pictures"]

_NAMED = 5
"""Largest number of videos that a message names."""


def frames_of_pictures(
    listed: Sequence[Listed], validator: ImportValidator, folder: Path, more: Iterable[str] = ()
) -> list[int | None]:
    """Return the ordinal of each picture; None: it is of another video, which is reported.

    Args:
        listed: all pictures of the import.
        validator: takes the reports; has the video and the switches.
        folder: the import's folder; a manifest of ours beside it decides which video names mean.
        more: names of pictures without boxes, from a list beside the boxes; they help to find where numbers begin.

    Raises:
        ImportFormatError: names without number, numbers beyond the video, a count that may begin at 0 or at 1, several
            videos and none is this one, two pictures of one frame, or pictures that Roboflow has changed.
    """
    refuse_changed_pictures(folder, validator.target.video)
    out: list[int | None] = [None] * len(listed)
    rows, nameless, differ = rows_of(listed, validator.target.video, folder, more)
    chosen = _chosen(rows, nameless, listed, validator)
    for row in chosen:
        _take(row, listed, validator, out)
    _refuse_twins(listed, out, validator)
    for place, what in differ:
        if out[place] is not None:
            validator.count(
                what, listed[place].file, f"{listed[place].name[:80]!r} {listed[place].instead[:80]}".strip()
            )
    _tell_others([row for row in rows if row not in chosen], nameless, listed, validator)
    return out


def _chosen(
    rows: list[Row], nameless: list[Nameless], listed: Sequence[Listed], validator: ImportValidator
) -> list[Row]:
    """The rows of the video, or the only possible ones."""
    video, said = validator.target.video.name, validator.target.switches.get("video", "auto")
    if said != "auto":
        found = [row for row in rows if plain_name(said) in row.called]
        if not found and listed:
            raise _several(rows, listed, f"none is called {said[:80]!r}, as video={said[:80]} asks for")
    else:
        found = [row for row in rows if row.own]
        # If the file states the video of some pictures, a folder of that name says nothing about the others.
        if any(row.stated for row in found):
            found = [row for row in found if row.stated or not row.first.video]
    bad = next((each for each in nameless if each.own or not found), None)
    if bad is not None:
        raise _no_number(listed[bad.place], bad.why)
    if not found and rows and not any(row.certain for row in rows):
        found = rows
        # Pictures of one name can be in several rows; without a name, each row can be another video.
        kinds = {(row.label.casefold() or row.name.pattern, row.folder) for row in rows}
        if len(kinds) > 1 or any(row.other for row in rows):
            raise _several(rows, listed, f"nothing says which are of {video}")
    if len({row.folder for row in found if not row.stated}) > 1:
        raise _several(found, listed, f"nothing says which are of {video}", by_folder=True)
    for name in dict.fromkeys(row.other_name for row in found if row.other_name):
        validator.repair(
            f"{listed[found[0].places[0]].file}: names {name[:80]!r}, not {video}. Its pictures were taken as "
            f"frames of {video}; check that it is the right video."
        )
    return found


def _take(row: Row, listed: Sequence[Listed], validator: ImportValidator, out: list[int | None]) -> None:
    """Find the frame of each picture of a row."""
    video = validator.target.video
    if row.seconds:
        for place, seconds in zip(row.places, row.seconds, strict=True):
            out[place] = _frame_at(seconds, listed[place], video)
        validator.repair(f"{listed[row.places[0]].file}: times in picture names were taken as the nearest frames.")
        return
    if row.frames:
        for place, frame in zip(row.places, row.frames, strict=True):
            out[place] = validator.frame(frame, listed[place].file, listed[place].line)
        return
    if row.name.ambiguous and len(set(row.numbers)) < 2:
        raise _no_number(listed[row.places[0]], "has two numbers, and nothing says which is the frame")
    counted = origin_of(
        *row.span,
        video.frames,
        asked=validator.target.switches.get("first_frame", "auto"),
        custom=row.custom(),
        what=row.what,
        fail=lambda rule: refuse(listed[row.places[0]].file, listed[row.places[0]].line, rule),
    )
    last = video.frames - 1 + counted.origin
    for place, number in (*zip(row.places, row.numbers, strict=True), *((row.places[0], end) for end in row.span)):
        if not counted.origin <= number <= last:
            raise refuse(
                listed[place].file,
                listed[place].line,
                f"frame {number} must be in {counted.origin} to {last}, the frames of {video.name}. Check that it is "
                "the right video and whether the file counts from 0 or 1 (first_frame).",
            )
    for place, number in zip(row.places, row.numbers, strict=True):
        out[place] = number - counted.origin
    if counted.reported:
        validator.repair(f"{listed[row.places[0]].file}: {counted.reported}")


def _frame_at(seconds: float, picture: Listed, video: DatasetVideo) -> int:
    """The frame nearest to a time, counted from the first frame."""
    times = video.times
    if times is None or not len(times):
        raise refuse(
            picture.file,
            picture.line,
            f"{picture.name[:80]!r} has a time, but the times of {video.name} are not known. Call it frame_000010.",
        )
    wanted = seconds + float(times[0])
    frame = int(np.argmin(np.abs(times - wanted)))
    beside = [abs(float(times[k] - times[frame])) for k in (frame - 1, frame + 1) if 0 <= k < len(times)]
    # Times in names are rounded.
    if abs(float(times[frame]) - wanted) > min(beside, default=0.0) / 2 + 0.0005:
        raise refuse(
            picture.file,
            picture.line,
            f"the time {seconds:g} s in {picture.name[:80]!r} is that of no frame of {video.name}, which lasts "
            f"{float(times[-1] - times[0]):.6g} s. Choose the right video.",
        )
    return frame


def _refuse_twins(listed: Sequence[Listed], out: list[int | None], validator: ImportValidator) -> None:
    """Refuse two pictures of one frame: they are of two videos, or one is a changed copy."""
    seen: dict[int, int] = {}
    again = 0
    for place, frame in enumerate(out):
        if frame is None:
            continue
        before = seen.setdefault(frame, place)
        if before == place:
            continue
        one, two = listed[before], listed[place]
        if one.name == two.name and one.file != two.file:
            again += 1
            continue
        raise refuse(
            two.file,
            two.line,
            f"is frame {frame}, as {place_of(one.file, one.line)} is. A frame has one picture: leave out the one of "
            "another video, of another subset, or that is an augmented copy.",
        )
    if again:
        listed_again = plural(again, "picture is", "pictures are")
        validator.repair(f"{listed_again} listed by several files; the boxes of all of these were taken.")


def _tell_others(
    rows: list[Row], nameless: list[Nameless], listed: Sequence[Listed], validator: ImportValidator
) -> None:
    if rows:
        count = sum(len(row.places) for row in rows)
        reason = f"They are of another video than {validator.target.video.name}"
        validator.skip(plural(count, "picture"), f"{reason}: {_listing(rows, lambda row: row.shown)}.")
    if nameless:
        first = listed[nameless[0].place]
        reason = f"Their names have no frame number, and do not name {validator.target.video.name}"
        validator.skip(plural(len(nameless), "picture"), f"{reason}; the first is {first.name[:80]!r}.")


def _several(rows: list[Row], listed: Sequence[Listed], why: str, *, by_folder: bool = False) -> ImportFormatError:
    file = listed[0].file
    found = _listing(rows, lambda row: "/".join(row.folder) or row.shown if by_folder else row.shown)
    return refuse(
        file,
        None,
        f"has pictures of {found}; {why}. Choose with video=NAME, or import onto the video that it is about.",
    )


def _listing(rows: list[Row], name: Callable[[Row], str]) -> str:
    counts: dict[str, int] = {}
    for row in rows:
        counts[name(row)] = counts.get(name(row), 0) + len(row.places)
    named = [f"{label[:60]!r} ({count})" for label, count in list(counts.items())[:_NAMED]]
    more = f" and {len(counts) - _NAMED} more" if len(counts) > _NAMED else ""
    return ", ".join(named) + more


def _no_number(picture: Listed, why: str) -> ImportFormatError:
    what = "its name" if picture.name == picture.file else f"the picture {picture.name[:80]!r}"
    return refuse(picture.file, picture.line, f"{what} {why}. Call it {SHAPES}.")
