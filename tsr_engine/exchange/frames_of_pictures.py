"""Finds the pictures of an import that belong to its video, and the frame of each.

The names are judged together. Pictures with the same folder and the same text before the number form a sequence.
Sequences that name the video are taken; the others are left out and reported. If none names it, a single sequence is
taken, and reported if it names another video; several are refused. Each sequence counts from 0 or from 1 as a whole.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.dataset import DatasetVideo
from tsr_engine.exchange.frame_numbering import find_origin
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.picture_names import EXPECTED_NAMES
from tsr_engine.exchange.picture_sequences import ListedPicture, PictureSequence, UnnumberedPicture, group_pictures
from tsr_engine.exchange.reading import location_of, rule_error
from tsr_engine.exchange.roboflow import refuse_changed_pictures
from tsr_engine.exchange.video_spellings import normalized_name
from tsr_engine.plural import plural

_MAX_NAMED = 5
"""Largest number of videos that a message names."""


def frames_of_pictures(
    listed: Sequence[ListedPicture], validator: ImportValidator, folder: Path, listed_names: Iterable[str] = ()
) -> list[int | None]:
    """Return the ordinal of each picture; None: it is of another video, which is reported.

    Args:
        listed: all pictures of the import.
        validator: takes the reports; has the video and the switches.
        folder: the import's folder; a manifest of ours beside it decides which video names mean.
        listed_names: names of pictures without boxes, from a list; they help to find where numbers begin.

    Raises:
        ImportFormatError: names without number, numbers beyond the video, a count that may begin at 0 or at 1, several
            videos and none is this one, two pictures of one frame, or pictures that Roboflow has changed.
    """
    refuse_changed_pictures(folder, validator.target.video)
    out: list[int | None] = [None] * len(listed)
    sequences, unnumbered, differences = group_pictures(listed, validator.target.video, folder, listed_names)
    chosen = _choose_sequences(sequences, unnumbered, listed, validator)
    for sequence in chosen:
        _assign_frames(sequence, listed, validator, out)
    _refuse_duplicates(listed, out, validator)
    for index, difference in differences:
        if out[index] is not None:
            validator.count(
                difference,
                listed[index].file,
                f"{listed[index].name[:80]!r} {listed[index].fallback_name[:80]}".strip(),
            )
    _report_others([sequence for sequence in sequences if sequence not in chosen], unnumbered, listed, validator)
    return out


def _choose_sequences(
    sequences: list[PictureSequence],
    unnumbered: list[UnnumberedPicture],
    listed: Sequence[ListedPicture],
    validator: ImportValidator,
) -> list[PictureSequence]:
    """The sequences of the video, or the only possible ones."""
    video, option = validator.target.video.name, validator.target.switches.get("video", "auto")
    if option != "auto":
        found = [sequence for sequence in sequences if normalized_name(option) in sequence.selectable_names]
        if not found and listed:
            raise _several_videos_error(
                sequences, listed, f"none is called {option[:80]!r}, as video={option[:80]} asks for"
            )
    else:
        found = [sequence for sequence in sequences if sequence.is_of_video]
        # If the file states the video of some pictures, a folder of that name says nothing about the others.
        if any(sequence.is_stated for sequence in found):
            found = [sequence for sequence in found if sequence.is_stated or not sequence.first.video]
    missing = next((each for each in unnumbered if each.is_of_video or not found), None)
    if missing is not None:
        raise _no_number_error(listed[missing.position], missing.reason)
    if not found and sequences and not any(sequence.is_certain for sequence in sequences):
        found = sequences
        # Pictures of one name can be in several sequences; without a name, each sequence can be another video.
        kinds = {(sequence.label.casefold() or sequence.name.pattern, sequence.folder) for sequence in sequences}
        if len(kinds) > 1 or any(sequence.is_of_other_video for sequence in sequences):
            raise _several_videos_error(sequences, listed, f"nothing says which are of {video}")
    if len({sequence.folder for sequence in found if not sequence.is_stated}) > 1:
        raise _several_videos_error(found, listed, f"nothing says which are of {video}", by_folder=True)
    for name in dict.fromkeys(sequence.other_name for sequence in found if sequence.other_name):
        validator.repair(
            f"{found[0].first.file}: names {name[:80]!r}, not {video}. Its pictures were taken as "
            f"frames of {video}; check that it is the right video."
        )
    return found


def _assign_frames(
    sequence: PictureSequence, listed: Sequence[ListedPicture], validator: ImportValidator, out: list[int | None]
) -> None:
    """Find the frame of each picture of a sequence."""
    video = validator.target.video
    if sequence.seconds:
        for index, seconds in zip(sequence.indices, sequence.seconds, strict=True):
            out[index] = _frame_at(seconds, listed[index], video)
        validator.repair(f"{sequence.first.file}: times in picture names were taken as the nearest frames.")
        return
    if sequence.frames:
        for index, frame in zip(sequence.indices, sequence.frames, strict=True):
            out[index] = validator.frame(frame, listed[index].file, listed[index].line)
        return
    if sequence.name.ambiguous and len(set(sequence.numbers)) < 2:
        raise _no_number_error(sequence.first, "has two numbers, and nothing says which is the frame")
    numbering = find_origin(
        *sequence.span,
        video.frames,
        requested=validator.target.switches.get("first_frame", "auto"),
        scheme=sequence.scheme(),
        what=sequence.number_kind,
        fail=lambda rule: rule_error(sequence.first.file, sequence.first.line, rule),
    )
    last = video.frames - 1 + numbering.origin
    for index, number in (
        *zip(sequence.indices, sequence.numbers, strict=True),
        *((sequence.indices[0], end) for end in sequence.span),
    ):
        if not numbering.origin <= number <= last:
            raise rule_error(
                listed[index].file,
                listed[index].line,
                f"frame {number} must be in {numbering.origin} to {last}, the frames of {video.name}. Check that it is "
                "the right video and whether the file counts from 0 or 1 (first_frame).",
            )
    for index, number in zip(sequence.indices, sequence.numbers, strict=True):
        out[index] = number - numbering.origin
    if numbering.report:
        validator.repair(f"{sequence.first.file}: {numbering.report}")


def _frame_at(seconds: float, picture: ListedPicture, video: DatasetVideo) -> int:
    """The frame nearest to a time, counted from the first frame."""
    times = video.times
    if times is None or not len(times):
        raise rule_error(
            picture.file,
            picture.line,
            f"{picture.name[:80]!r} has a time, but the times of {video.name} are not known. Call it frame_000010.",
        )
    wanted = seconds + float(times[0])
    frame = int(np.argmin(np.abs(times - wanted)))
    neighbour_distances = [abs(float(times[k] - times[frame])) for k in (frame - 1, frame + 1) if 0 <= k < len(times)]
    # Times in names are rounded.
    if abs(float(times[frame]) - wanted) > min(neighbour_distances, default=0.0) / 2 + 0.0005:
        raise rule_error(
            picture.file,
            picture.line,
            f"the time {seconds:g} s in {picture.name[:80]!r} is that of no frame of {video.name}, which lasts "
            f"{float(times[-1] - times[0]):.6g} s. Choose the right video.",
        )
    return frame


def _refuse_duplicates(listed: Sequence[ListedPicture], out: list[int | None], validator: ImportValidator) -> None:
    """Refuse two pictures of one frame: they are of two videos, or one is a changed copy."""
    seen: dict[int, int] = {}
    repeated = 0
    for index, frame in enumerate(out):
        if frame is None:
            continue
        earlier = seen.setdefault(frame, index)
        if earlier == index:
            continue
        one, two = listed[earlier], listed[index]
        if one.name == two.name and one.file != two.file:
            repeated += 1
            continue
        raise rule_error(
            two.file,
            two.line,
            f"is frame {frame}, as {location_of(one.file, one.line)} is. A frame has one picture: leave out the one of "
            "another video, of another subset, or that is an augmented copy.",
        )
    if repeated:
        count = plural(repeated, "picture is", "pictures are")
        validator.repair(f"{count} listed by several files; the boxes of all of these were taken.")


def _report_others(
    sequences: list[PictureSequence],
    unnumbered: list[UnnumberedPicture],
    listed: Sequence[ListedPicture],
    validator: ImportValidator,
) -> None:
    if sequences:
        count = sum(len(sequence.indices) for sequence in sequences)
        reason = f"They are of another video than {validator.target.video.name}"
        validator.skip(
            plural(count, "picture"), f"{reason}: {_listing(sequences, lambda sequence: sequence.display_name)}."
        )
    if unnumbered:
        first = listed[unnumbered[0].position]
        reason = f"Their names have no frame number, and do not name {validator.target.video.name}"
        validator.skip(plural(len(unnumbered), "picture"), f"{reason}; the first is {first.name[:80]!r}.")


def _several_videos_error(
    sequences: list[PictureSequence], listed: Sequence[ListedPicture], reason: str, *, by_folder: bool = False
) -> ImportFormatError:
    file = listed[0].file
    found = _listing(
        sequences,
        lambda sequence: "/".join(sequence.folder) or sequence.display_name if by_folder else sequence.display_name,
    )
    return rule_error(
        file,
        None,
        f"has pictures of {found}; {reason}. Choose with video=NAME, or import onto the video that it is about.",
    )


def _listing(sequences: list[PictureSequence], name: Callable[[PictureSequence], str]) -> str:
    counts = Counter[str]()
    for sequence in sequences:
        counts[name(sequence)] += len(sequence.indices)
    named = [f"{label[:60]!r} ({count})" for label, count in list(counts.items())[:_MAX_NAMED]]
    more = f" and {len(counts) - _MAX_NAMED} more" if len(counts) > _MAX_NAMED else ""
    return ", ".join(named) + more


def _no_number_error(picture: ListedPicture, reason: str) -> ImportFormatError:
    what = "its name" if picture.name == picture.file else f"the picture {picture.name[:80]!r}"
    return rule_error(picture.file, picture.line, f"{what} {reason}. Call it {EXPECTED_NAMES}.")
