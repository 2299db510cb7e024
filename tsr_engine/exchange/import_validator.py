"""Applies the rules of every import.

A reader hands each row to an ``ImportValidator``, which refuses or repairs it with a sentence that names file, line and
rule, and makes the tracks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from tsr_engine.exchange.added_attributes import add_attributes
from tsr_engine.exchange.added_labels import DeclaredLabel
from tsr_engine.exchange.box_rules import BoxRules, Edges
from tsr_engine.exchange.dataset import UNSTATED_LABEL, Dataset, Skipped, Track
from tsr_engine.exchange.formats import ImportTarget, Switch
from tsr_engine.exchange.label_resolver import SKIPPED_LABEL, LabelResolver
from tsr_engine.exchange.notes import notes_from_text
from tsr_engine.exchange.reading import location_of, rule_error, too_many_error
from tsr_engine.exchange.track_builder import TrackBuilder
from tsr_engine.exchange.track_rows import BOX, END, TrackRows
from tsr_engine.io.plain_numbers import parse_real
from tsr_engine.json_shapes import JsonMapping

_STATES = frozenset({"open", "accepted", "rejected", "needs_work", "truth"})
_BOXES_PER_REPORT = 2000
"""Number of boxes between two progress reports."""

SIZE_SWITCH = Switch("size", ("refuse", "scale"), "What to do when the file's pictures have another size.")


class ImportValidator:
    """Takes rows of a file in any order, checks them, and makes the data set.

    Refused (``ImportFormatError``): frames outside the video, two different boxes of one track in one frame, and,
    unless the switch ``bad_boxes`` is ``skip``, boxes without area or without four finite numbers. Repaired, with
    one sentence a kind: boxes across the edge of the picture are clipped, repeated rows are taken once.
    Skipped: boxes wholly outside the picture.
    Names that match no label are refused in one list after the whole file is read, unless
    ``ImportTarget.unknown`` says what to do with them.
    """

    def __init__(self, target: ImportTarget) -> None:
        """Take the video, labels and switches of the import."""
        self.target = target
        self._names = LabelResolver(target)
        self.boxes = BoxRules(target)
        self._box_count = 0
        self._tracks: dict[str, TrackRows] = {}
        self._skipped: list[Skipped] = []
        self._repaired: list[str] = []
        self._counts: dict[str, tuple[int, str, int | str | None]] = {}
        self._next_suffix: dict[str, int] = {}
        self._files: dict[str, int] = {}

    def __len__(self) -> int:
        return len(self._tracks)

    def __contains__(self, uid: str) -> bool:
        return uid in self._tracks

    def label(self, name: str, file: str, line: int | str | None = None, *, number: bool = False) -> int:
        """The id of a name's label, -1 for "unknown sign". Below ``UNSTATED_LABEL``: no label matches, see ``finish``.

        Args:
            name: as the file writes it.
            file: for messages.
            line: for messages.
            number: the file has a number, not a name; it is taken as an id, which the reader reports.
        """
        return self._names.label(name, file, line, number)

    def declare(self, name: str, declared: DeclaredLabel) -> None:
        """Take the declaration of a label; an empty name declares for every label.

        It is used if the label, or an attribute of it that tracks have, is added to the set.
        """
        self._names.declared[name] = declared

    def repair(self, message: str) -> None:
        """Report a repair."""
        self._repaired.append(message)

    def count(self, what: str, file: str, line: int | str | None = None) -> None:
        """Count a repair; each kind (``what``) is reported once, with its number and first place."""
        count, first_file, first_line = self._counts.get(what, (0, file, line))
        self._counts[what] = (count + 1, first_file, first_line)

    def skip(self, what: str, reason: str) -> None:
        """Report what was left out and why."""
        self._skipped.append(Skipped(what, reason))

    def unique_uid(self, uid: str, file: str, line: int | str | None = None) -> str:
        """A name for a new track: ``uid``, or if that is taken ``uid-2`` and so on, which is reported."""
        if uid not in self._tracks:
            return uid
        suffix = self._next_suffix.get(uid, 2)
        while f"{uid}-{suffix}" in self._tracks:
            suffix += 1
        self._next_suffix[uid] = suffix
        self.count(f"Tracks whose name was taken got another name ({uid} is now {uid}-{suffix})", file, line)
        return f"{uid}-{suffix}"

    def scale(self, width: float, height: float, file: str, line: int | str | None = None) -> tuple[float, float]:
        """Factors from the size of the file's pictures to the video's; (1, 1) if they are equal.

        Raises:
            ImportFormatError: the sizes differ, and the switch ``size`` is not ``scale``.
        """
        video = self.target.video
        if (width, height) == (video.width, video.height):
            return 1.0, 1.0
        if self.target.switches.get("size") == "scale" and 0 < width < 1e6 and 0 < height < 1e6:
            reported = f"{file}: boxes were scaled from {width:g}x{height:g} to {video.width}x{video.height} px."
            if reported not in self._repaired:
                self._repaired.append(reported)
            return video.width / width, video.height / height
        raise rule_error(
            file,
            line,
            f"has a picture size of {width:g}x{height:g} px, {video.name} has {video.width}x{video.height}. Choose the "
            "right video, or import with size=scale.",
        )

    def check_rate(self, rate: float, file: str, line: int | str | None = None) -> None:
        """Report a frame rate that is not the video's, unless it was rounded; 0 and NaN state no rate."""
        video = self.target.video
        own = 0.0 if video.rate is None else float(video.rate)
        is_rounded = rate == rate // 1 and abs(rate - own) <= 0.5
        if own and rate > 0 and abs(rate - own) > 0.01 * own and not is_rounded:
            self.repair(
                f"{location_of(file, line)}: says {rate:g} frames/s, {video.name} has {own:g}. Its frames were taken "
                "by their number; check that it counts every frame."
            )

    def describe(
        self,
        uid: str,
        *,
        state: str = "open",
        source: str = "imported",
        notes: Sequence[tuple[int, str]] = (),
        until: int = -1,
        attributes: JsonMapping | None = None,
    ) -> None:
        """Set facts about a track other than its boxes; creates the track if it is new.

        Args:
            uid: the track's name.
            state: review state; an unknown one becomes ``open``.
            source: as in ``Track``.
            notes: frame and text; a frame outside the video becomes the nearest one.
            until: the box of the last key frame holds up to this frame, inclusive; -1: it does not.
            attributes: attributes of the whole track, as in the file.
        """
        rows = self._tracks.get(uid) or self._new(uid)
        rows.state = state if state in _STATES else "open"
        rows.source = source
        last = self.target.video.frames - 1
        rows.notes.extend((min(max(frame, 0), last), text) for frame, text in notes)
        rows.until = max(rows.until, until)
        rows.track_attributes |= attributes or {}

    def frame(self, frame: float | str, file: str, line: int | str | None = None, *, origin: int = 0) -> int:
        """Convert a frame number to an ordinal.

        Raises:
            ImportFormatError: it is not a whole number, or not a frame of the video.
        """
        try:
            number = parse_real(frame) if isinstance(frame, str) else float(frame)
            ordinal = int(number) - origin
        except (TypeError, ValueError, OverflowError):
            raise rule_error(file, line, f"frame {str(frame)[:40]!r} must be a whole number. Correct it.") from None
        count, video = self.target.video.frames, self.target.video.name
        if number != int(number) or not 0 <= ordinal < count:
            raise rule_error(
                file,
                line,
                f"frame {number:.12g} must be in {origin} to {count - 1 + origin}, the frames of {video}. "
                "Check that it is the right video and whether the file counts from 0 or 1.",
            )
        return ordinal

    def box(
        self,
        uid: str,
        frame: int,
        edges: Edges,
        label: int,
        *,
        file: str,
        line: int | str | None = None,
        key: bool = True,
        occluded: bool = False,
        ignore: bool = False,
        score: float = math.nan,
        attributes: JsonMapping | None = None,
        facts: tuple[str, str, str] | None = None,
    ) -> bool:
        """Take one box of a track; return whether it was taken.

        ``frame`` is an ordinal, ``label`` may be ``UNSTATED_LABEL``.

        ``attributes`` are attributes as in the file; they hold up to the track's next box. ``facts`` are the state, the
        source and the note of the track; those of its first box count.

        Raises:
            ImportFormatError: the box breaks a rule.
        """
        if not self.boxes.check(edges, file, line):
            return False
        if not 0 <= frame < self.target.video.frames:
            self.frame(frame, file, line)
        if not (score != score or 0.0 <= score <= 1.0):
            raise rule_error(file, line, f"score {score} must be in 0 to 1. Scale the scores.")
        clipped = self.boxes.clip(uid, edges, file, line)
        if clipped is None:
            return False
        edges, is_reported = clipped
        if is_reported:
            self.count("Boxes that reached over the edge of the picture were cut there", file, line)
        rows = self._tracks.get(uid)
        if rows is None:
            rows = self._new(uid, file, line)
            if facts is not None:
                state, source, note = facts
                self.describe(uid, state=state, source=source, notes=notes_from_text(note, frame))
        self._box_count += 1
        if self._box_count > self.target.limits.boxes:
            raise too_many_error("boxes", self.target.limits.boxes, file, line)
        if self.target.progress is not None and not self._box_count % _BOXES_PER_REPORT:
            self.target.progress(self._box_count)
        if attributes:
            rows.row_attributes[len(rows.frame)] = attributes
        rows.frame.append(frame)
        rows.kind.append(BOX)
        rows.edges.extend(edges)
        rows.label.append(label)
        rows.flags.append(key | occluded << 1 | ignore << 2)
        rows.score.append(score)
        rows.line.append(line if isinstance(line, int) else -1)
        rows.file.append(self._files.setdefault(file, len(self._files)))
        return True

    def hide_from(self, uid: str, frame: int) -> None:
        """Hide the track from this frame on until its next box; the frame may lie beyond the last one."""
        rows = self._tracks.get(uid) or self._new(uid)
        rows.frame.append(frame)
        rows.kind.append(END)
        rows.edges.extend((0.0, 0.0, 0.0, 0.0))
        rows.label.append(UNSTATED_LABEL)
        rows.flags.append(0)
        rows.score.append(math.nan)
        rows.line.append(-1)
        rows.file.append(-1)

    def _new(self, uid: str, file: str = "", line: int | str | None = None) -> TrackRows:
        """Rows for a new track."""
        if len(self._tracks) >= self.target.limits.tracks:
            raise too_many_error("tracks", self.target.limits.tracks, file or "The file", line)
        rows = self._tracks[uid] = TrackRows()
        return rows

    def finish(self, file: str, *, interpolate: bool = False) -> Dataset:
        """The data set: one video, its tracks in the order of their first rows.

        Args:
            file: for messages.
            interpolate: draw straight lines from each box to the track's next one, unless the track is hidden between
                them; before it is hidden the box stands still.

        Raises:
            ImportFormatError: a track has two different boxes in one frame.
        """
        labels, ids = self._names.resolve(self._tracks.values(), file)
        self._skipped += self._names.skipped
        self._repaired += self._names.repaired
        tracks: list[Track] = []
        maker = TrackBuilder(file, list(self._files), self.target.limits, interpolate, ids, self.count)
        for uid, rows in self._tracks.items():
            track = maker.build(uid, rows, len(tracks))
            if track is not None:
                tracks.append(track)
            elif not any(ids.get(label) == SKIPPED_LABEL for label in rows.label):
                self.skip(f"{file}: track {uid}", "It has no visible box.")
        if maker.attributes_by_track:
            declared = self._names.declared_by_id(labels, ids)
            labels, left = add_attributes(
                labels, tracks, maker.attributes_by_track, declared, self._names.adds_attributes, file
            )
            self._skipped += left
        self._repaired += self._names.remembered_reports()
        self._skipped += self.boxes.skipped()
        for what, (count, first_file, line) in self._counts.items():
            self._repaired.append(f"{what}: {count}; the first is {location_of(first_file, line)}.")
        video = self.target.video
        result = replace(video, tracks=lambda: iter(tracks), stop=video.stop or video.frames)
        return Dataset(labels, (result,), tuple(self._skipped), tuple(self._repaired))
