"""The rules that every import and export obeys, in one place.

A reader hands each row to an ``ImportValidator``, which refuses or repairs it with a sentence that names file, line and
rule, and makes the tracks. ``check_track`` guards the writers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, TypeVar, cast

import numpy as np

from tsr_engine.counted import counted
from tsr_engine.errors import ExportError, ImportFormatError
from tsr_engine.exchange.additions import Declared, Said, attributed
from tsr_engine.exchange.dataset import NONE, UNSAID, Dataset, DatasetVideo, Skipped, Track
from tsr_engine.exchange.formats import BAD_BOXES, ImportTarget, Switch
from tsr_engine.exchange.names_in_file import LEFT_OUT, NamesInFile
from tsr_engine.exchange.reading import MAX_JSON_BYTES, place_of, read_json, read_text, refuse
from tsr_engine.exchange.track_rows import BOX, END, TrackRows, common_label, dense
from tsr_engine.io.plain_numbers import real_number

__all__ = [
    "MAX_JSON_BYTES",
    "NO_BOX",
    "SIZE_SWITCH",
    "ImportValidator",
    "check_track",
    "read_json",
    "read_text",
    "refuse",
]

_STATES = frozenset({"open", "accepted", "rejected", "needs_work", "truth"})
_SAME_PX = 1e-6

Edges = tuple[float, float, float, float]
Numbers = TypeVar("Numbers", bound=tuple[float, ...])

NO_BOX: Edges = (math.nan, math.nan, math.nan, math.nan)
"""What ``ImportValidator.edges`` gives for a box that is left out; told by its identity."""

_TELL = 2000
"""Boxes from one time that somebody is told how many have been read to the next."""

SIZE_SWITCH = Switch("size", ("refuse", "scale"), "What to do when the file is about pictures of another size.")


def check_track(track: Track, video: DatasetVideo, labels: Collection[int]) -> None:
    """The promises of ``Track``, for the writers; ``labels`` are the ids of the set.

    Raises:
        ExportError: one is broken; names video, track and frame.
    """

    def fail(rule: str) -> ExportError:
        return ExportError(f"{video.name}, track {track.uid!r}: {rule} Correct the track, or leave it out.")

    n = len(track.frames)
    if n == 0:
        raise fail("has no boxes.")
    for name in ("key", "occluded", "score", "labels", "ignore", "silent"):
        values = getattr(track, name)
        if values is not None and values.shape != (n,):
            raise fail(f"{name} has shape {values.shape}, must have ({n},).")
    if track.boxes.shape != (n, 4):
        raise fail(f"boxes have shape {track.boxes.shape}, must have ({n}, 4).")
    if n > 1 and not (np.diff(track.frames) > 0).all():
        raise fail("has two boxes in one frame, or frames out of order.")
    if track.frames[0] < 0 or track.frames[-1] >= video.frames:
        raise fail(f"frames {track.frames[0]} to {track.frames[-1]} must be in 0 to {video.frames - 1}.")
    bad = ~np.isfinite(track.boxes).all(axis=1)
    bad |= (track.boxes[:, 0] >= track.boxes[:, 2]) | (track.boxes[:, 1] >= track.boxes[:, 3])
    if bad.any():
        k = int(np.flatnonzero(bad)[0])
        raise fail(f"frame {track.frames[k]}: box {track.boxes[k].tolist()} must be finite with x1 < x2, y1 < y2.")
    if any(values.shape != (n,) for values in track.changing.values()):
        raise fail(f"has an attribute that does not have {n} answers.")
    used = {track.label} if track.labels is None else {track.label, *np.unique(track.labels).tolist()}
    strange = [label for label in used if label != NONE and label not in labels]
    if strange:
        raise fail(f"has the label {strange[0]}, which its set has never given out.")


class ImportValidator:
    """Takes rows of a file in any order, checks them, and makes the data set.

    Refused (``ImportFormatError``): frames outside of the video, two different boxes of one track in one frame, and,
    unless the switch ``bad_boxes`` says ``skip``, boxes without area or without four finite numbers. Repaired, each
    kind with one sentence: boxes that reach over the picture's edge are cut there, the same row twice is taken once.
    Skipped: boxes wholly outside of the picture.
    Names that no label has are refused with a list of all, once the file is read, unless ``ImportTarget.unknown`` says
    what becomes of them.
    """

    def __init__(self, target: ImportTarget) -> None:
        """Take what the file is read onto."""
        self.target = target
        self._names = NamesInFile(target)
        self._boxes = self._taken = 0
        self._outside, self._first_outside = 0, ""
        self._bad, self._first_bad = 0, ""
        self._tracks: dict[str, TrackRows] = {}
        self._skipped: list[Skipped] = []
        self._repaired: list[str] = []
        self._counts: dict[str, list[Any]] = {}
        self._again: dict[str, int] = {}

    def __len__(self) -> int:
        return len(self._tracks)

    def __contains__(self, uid: str) -> bool:
        return uid in self._tracks

    def label(self, name: str, file: str, line: int | str | None = None, *, number: bool = False) -> int:
        """The id of a name's label, -1 for "unknown sign"; below ``UNSAID``: no label has it, which ``finish`` settles.

        Args:
            name: as it stands in the file.
            file: for messages.
            line: for messages.
            number: the file has a number there, not a name; it is an id, which the reader reports.
        """
        return self._names.label(name, file, line, number)

    def declare(self, name: str, declared: Declared) -> None:
        """What the file says of a label, or by an empty name of every label.

        It counts where the label, or attributes of it that tracks have, are added to the set.
        """
        self._names.declared[name] = declared

    def repair(self, sentence: str) -> None:
        """Tell what was put right."""
        self._repaired.append(sentence)

    def count(self, what: str, file: str, line: int | str | None = None) -> None:
        """Tell of one more repair of a kind: ``what`` is said once, with the number and the first place."""
        entry = self._counts.setdefault(what, [0, file, line])
        entry[0] += 1

    def skip(self, what: str, reason: str) -> None:
        """Tell what was left out and why."""
        self._skipped.append(Skipped(what, reason))

    def unique(self, uid: str, file: str, line: int | str | None = None) -> str:
        """A name for a new track: ``uid``, or where that is taken already ``uid-2`` and so on, with a sentence."""
        if uid not in self._tracks:
            return uid
        again = self._again.get(uid, 2)
        while f"{uid}-{again}" in self._tracks:
            again += 1
        self._again[uid] = again
        self.count(f"Tracks whose name was taken were given another one ({uid} is now {uid}-{again})", file, line)
        return f"{uid}-{again}"

    def scale(self, width: float, height: float, file: str, line: int | str | None = None) -> tuple[float, float]:
        """Factors from the pictures that a file is about to those of the video; (1, 1) where they have one size.

        Raises:
            ImportFormatError: other size, unless the switch ``size`` says ``scale``.
        """
        video = self.target.video
        if (width, height) == (video.width, video.height):
            return 1.0, 1.0
        if self.target.switches.get("size") == "scale" and 0 < width < 1e6 and 0 < height < 1e6:
            reported = f"{file}: boxes were scaled from {width:g}x{height:g} to {video.width}x{video.height} px."
            if reported not in self._repaired:
                self._repaired.append(reported)
            return video.width / width, video.height / height
        raise refuse(
            file,
            line,
            f"is about pictures of {width:g}x{height:g} px, {video.name} has {video.width}x{video.height}. Choose the "
            "right video, or import with size=scale.",
        )

    def describe(
        self,
        uid: str,
        *,
        state: str = "open",
        source: str = "imported",
        notes: Sequence[tuple[int, str]] = (),
        until: int = -1,
        said: Mapping[str, Any] | None = None,
    ) -> None:
        """What is known of a track besides its boxes; makes the track if it is new.

        Args:
            uid: the track.
            state: taken as ``open`` where it is none of the states.
            source: as in ``Track``.
            notes: frame and text; a frame outside of the video becomes its nearest one.
            until: the last key frame's box holds up to this frame, inclusive; -1: it does not.
            said: attributes of the whole track as they stand in the file.
        """
        rows = self._tracks.get(uid) or self._new(uid)
        rows.state = state if state in _STATES else "open"
        rows.source = source
        last = self.target.video.frames - 1
        rows.notes.extend((min(max(frame, 0), last), text) for frame, text in notes)
        rows.until = max(rows.until, until)
        rows.always |= said or {}

    def frame(self, frame: float | str, file: str, line: int | str | None = None, *, origin: int = 0) -> int:
        """A frame number as an ordinal.

        Raises:
            ImportFormatError: not a whole number, or not a frame of the video.
        """
        try:
            number = real_number(frame) if isinstance(frame, str) else float(frame)
            ordinal = int(number) - origin
        except (TypeError, ValueError, OverflowError):
            raise refuse(file, line, f"frame {str(frame)[:40]!r} must be a whole number. Correct it.") from None
        count, video = self.target.video.frames, self.target.video.name
        if number != int(number) or not 0 <= ordinal < count:
            raise refuse(
                file,
                line,
                f"frame {number:.12g} must be in {origin} to {count - 1 + origin}, the frames of {video}. "
                "Check that it is the right video and whether the file counts from 0 or 1.",
            )
        return ordinal

    def edges(self, read: Callable[[], Numbers]) -> Numbers:
        """The edges, or other numbers of a box, that ``read`` finds; ``NO_BOX`` where the box is left out instead.

        Raises:
            ImportFormatError: that of ``read``, with what else a person can do.
        """
        try:
            return read()
        except ImportFormatError as error:
            self._leave_out(error)
            return cast(Numbers, NO_BOX)

    def takes(self, edges: Edges, file: str, line: int | str | None = None) -> bool:
        """Whether edges are those of a box; False: it is left out.

        Raises:
            ImportFormatError: they are not, unless the switch ``bad_boxes`` says ``skip``.
        """
        if edges is NO_BOX:
            return False
        x1, y1, x2, y2 = edges
        # NaN fails every comparison.
        if -math.inf < x1 < x2 < math.inf and -math.inf < y1 < y2 < math.inf:
            return True
        if not all(map(math.isfinite, edges)):
            rule = f"box {_text(edges)} must have four finite numbers. Correct it."
        else:
            rule = f"box {_text(edges)} must have a positive width and height. Correct it, or delete the row."
        self._leave_out(refuse(file, line, rule))
        return False

    def _leave_out(self, error: ImportFormatError) -> None:
        if self.target.switches.get(BAD_BOXES.name) != "skip":
            way_out = f"Or import with {BAD_BOXES.name}=skip, which leaves such boxes out."
            raise ImportFormatError(f"{error} {way_out}", error.kind) from None
        self._bad += 1
        self._first_bad = self._first_bad or str(error)

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
        said: Mapping[str, Any] | None = None,
    ) -> bool:
        """One box of one track; ``frame`` is an ordinal, ``label`` may be ``UNSAID``. False: it was left out.

        ``said`` are attributes as they stand in the file; they hold up to the track's next box.

        Raises:
            ImportFormatError: it breaks a rule.
        """
        if not self.takes(edges, file, line):
            return False
        video = self.target.video
        x1, y1, x2, y2 = edges
        if not 0 <= frame < video.frames:
            self.frame(frame, file, line)
        if not (score != score or 0.0 <= score <= 1.0):
            raise refuse(file, line, f"score {score} must be in 0 to 1. Scale the scores.")
        if x1 < 0 or y1 < 0 or x2 > video.width or y2 > video.height:
            cut = (max(x1, 0.0), max(y1, 0.0), min(x2, float(video.width)), min(y2, float(video.height)))
            if cut[0] >= cut[2] or cut[1] >= cut[3]:
                self._outside += 1
                self._first_outside = self._first_outside or f"{place_of(file, line)}, track {uid}: {_text(edges)}"
                return False
            # Files with rounded numbers overshoot by half of their last digit.
            if max(cut[0] - x1, cut[1] - y1, x2 - cut[2], y2 - cut[3]) > 0.011:
                self.count("Boxes that reached over the edge of the picture were cut there", file, line)
            x1, y1, x2, y2 = cut
        rows = self._tracks.get(uid)
        if rows is None:
            rows = self._new(uid, file, line)
        self._taken += 1
        if self._taken > self.target.limits.boxes:
            raise self._too_many("boxes", self.target.limits.boxes, file, line)
        if self.target.tell is not None and not self._taken % _TELL:
            self.target.tell(self._taken)
        if said:
            rows.said[len(rows.frame)] = said
        rows.frame.append(frame)
        rows.kind.append(BOX)
        rows.edges.extend((x1, y1, x2, y2))
        rows.label.append(label)
        rows.flags.append(key | occluded << 1 | ignore << 2)
        rows.score.append(score)
        rows.place.append(line if isinstance(line, int) else -1)
        return True

    def end(self, uid: str, frame: int) -> None:
        """From this frame on the track is not shown, until its next box; may lie beyond the last frame."""
        rows = self._tracks.get(uid) or self._new(uid)
        rows.frame.append(frame)
        rows.kind.append(END)
        rows.edges.extend((0.0, 0.0, 0.0, 0.0))
        rows.label.append(UNSAID)
        rows.flags.append(0)
        rows.score.append(math.nan)
        rows.place.append(-1)

    def _new(self, uid: str, file: str = "", line: int | str | None = None) -> TrackRows:
        """Rows for a track that comes for the first time."""
        if len(self._tracks) >= self.target.limits.tracks:
            raise self._too_many("tracks", self.target.limits.tracks, file or "The file", line)
        rows = self._tracks[uid] = TrackRows()
        return rows

    @staticmethod
    def _too_many(what: str, most: int, file: str, line: int | str | None = None) -> ImportFormatError:
        return refuse(
            file, line, f"holds more than {most} {what}, the most that one import takes. Split it.", "too_large"
        )

    def finish(self, file: str, *, interpolate: bool = False) -> Dataset:
        """The data set: one video, its tracks in the order in which they first came.

        Args:
            file: for messages.
            interpolate: draw straight lines from each box to the track's next one, unless ``end`` lies between;
                before an ``end`` the box stands still.

        Raises:
            ImportFormatError: a track has two different boxes in one frame.
        """
        labels, ids, reported = self._names.settle(self._tracks.values(), file)
        self._skipped += reported.skipped
        self._repaired += reported.repaired
        tracks: list[Track] = []
        said: dict[int, Sequence[Said]] = {}
        for uid, rows in self._tracks.items():
            track = self._track(uid, rows, file, interpolate, ids, said, len(tracks))
            if track is not None:
                tracks.append(track)
            elif not any(ids.get(label) == LEFT_OUT for label in rows.label):
                self.skip(f"{file}: track {uid}", "It has no box that is shown.")
        if said:
            declared = self._names.declared_of(labels, ids)
            labels, left = attributed(labels, tracks, said, declared, self._names.adds, file)
            self._skipped += left
        self._repaired += self._names.recalled()
        self._tell_counts()
        video = self.target.video
        described = DatasetVideo(
            name=video.name,
            sha256=video.sha256,
            width=video.width,
            height=video.height,
            frames=video.frames,
            rate=video.rate,
            times=video.times,
            constant_rate=video.constant_rate,
            tracks=lambda: iter(tracks),
            path=video.path,
            first=video.first,
            stop=video.stop or video.frames,
            limits=video.limits,
        )
        return Dataset(labels, (described,), tuple(self._skipped), tuple(self._repaired))

    def _tell_counts(self) -> None:
        if self._outside:
            self.skip(
                counted(self._outside, "box", "boxes"),
                f"They lie outside of the picture; the first: {self._first_outside}.",
            )
        if self._bad:
            self.skip(
                counted(self._bad, "box", "boxes"),
                "They have no area, or coordinates that are missing or no numbers "
                f"({BAD_BOXES.name}=skip); the first: {self._first_bad}",
            )
        for what, (count, file, line) in self._counts.items():
            self._repaired.append(f"{what}: {count}; the first is {place_of(file, line)}.")

    def _track(
        self,
        uid: str,
        rows: TrackRows,
        file: str,
        interpolate: bool,
        ids: Mapping[int, int],
        said: dict[int, Sequence[Said]],
        place: int,
    ) -> Track | None:
        """The track of some rows, and in ``said`` at its ``place`` what they say; None: nothing is shown of it."""
        frames = np.frombuffer(rows.frame, dtype=np.int64)
        kind = np.frombuffer(rows.kind, dtype=np.int8)
        # A box and an end in one frame: the box is shown, the end says nothing.
        order = np.lexsort((kind, frames)) if len(frames) > 1 else np.zeros(len(frames), np.int64)
        take = order
        if len(order) > 1 and (np.diff(frames[order]) == 0).any():
            take = self._without_twins(uid, rows, order, file)
        frames, kind = frames[take], kind[take]
        edges = np.frombuffer(rows.edges, dtype=np.float64).reshape(-1, 4)[take]
        label = np.frombuffer(rows.label, dtype=np.int64)[take]
        if ids:
            label = np.array([ids.get(each, each) for each in label.tolist()], np.int64)
            left = label != LEFT_OUT
            take, frames, kind, edges, label = take[left], frames[left], kind[left], edges[left], label[left]
        flags = np.frombuffer(rows.flags, dtype=np.int8)[take]
        score = np.frombuffer(rows.score, dtype=np.float64)[take]
        is_box = kind == BOX
        if not is_box.any():
            return None
        if interpolate:
            self._boxes += max(int(frames[-1]), rows.until) + 1 - int(frames[0])
            if self._boxes > self.target.limits.boxes:
                raise self._too_many("boxes, with those between its key frames,", self.target.limits.boxes, file)
            at = np.arange(len(frames))
            frames, edges, at, flags, score = dense(frames, is_box, edges, at, flags, score, rows.until)
        else:
            at = np.flatnonzero(is_box)
            frames, edges, flags, score = frames[is_box], edges[is_box], flags[is_box], score[is_box]
        label = label[at]
        if rows.said or rows.always:
            said[place] = _said(rows, take[at])
        common, silent, label = common_label(label), label == UNSAID, np.maximum(label, NONE)
        ignore = (flags & 4) > 0
        return Track(
            uid=uid,
            label=common,
            frames=frames.copy(),
            boxes=edges.copy(),
            key=(flags & 1) > 0,
            occluded=(flags & 2) > 0,
            score=score.copy(),
            labels=None if (label == common).all() else label,
            ignore=ignore if ignore.any() else None,
            silent=silent if silent.any() else None,
            state=rows.state,
            source=rows.source,
            notes=tuple(rows.notes),
        )

    def _without_twins(self, uid: str, rows: TrackRows, order: np.ndarray[Any, Any], file: str) -> np.ndarray[Any, Any]:
        take: list[int] = []
        for place in order.tolist():
            before = take[-1] if take else -1
            if before < 0 or rows.frame[before] != rows.frame[place]:
                take.append(place)
                continue
            if rows.kind[place] == END:
                continue
            line = rows.place[place] if rows.place[place] >= 0 else None
            ours, other = rows.edges[4 * place : 4 * place + 4], rows.edges[4 * before : 4 * before + 4]
            if max(abs(a - b) for a, b in zip(ours, other, strict=True)) > _SAME_PX or (
                rows.label[place] != rows.label[before]
            ):
                raise refuse(
                    file,
                    line,
                    f"track {uid!r} has a second, different box in frame {rows.frame[place]}; a track has one box a "
                    "frame. Give the other sign its own id, or delete one.",
                )
            self.count("Boxes that were there twice were taken once", file, line)
        return np.array(take, dtype=np.int64)


def _text(edges: tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{edge:g}" for edge in edges) + ")"


def _said(rows: TrackRows, places: np.ndarray[Any, Any]) -> list[Said]:
    """What is said in each frame of a track; one object for all frames of one row."""
    known: dict[int, Said] = {}
    for place in set(places.tolist()):
        own = rows.said.get(place)
        known[place] = own if own is not None and not rows.always else {**rows.always, **(own or {})} or None
    return [known[place] for place in places.tolist()]
