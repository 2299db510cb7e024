"""Warnings about a video that decodes, in one sentence each."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
import numpy as np

from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.video_decoder import Decoder
from tsr_engine.io.video_kinds import Kind
from tsr_engine.io.video_parts import ContainerLayout
from tsr_engine.io.video_probe import video_streams
from tsr_engine.io.video_times import NO_TIME, Scan, Timeline
from tsr_engine.plural import plural

# Containers without a frame count state a duration, which muxers round and sound tracks extend.
_DURATION_TOLERANCE_S = Fraction(1, 2)
_MAX_LISTED = 3
"""Largest number of places that a warning lists; it counts the others."""


@dataclass(frozen=True, slots=True)
class HeaderInfo:
    """Statements of the header; never trusted, only compared.

    Attributes:
        frames: number of coded pictures; None: the container does not state it.
        shown: number of pictures in the container's index after edit lists have hidden others.
        seconds: duration of the video stream; None: neither stated by the container nor estimated by the demuxer.
        rate: average frames per second.
        rate_is_stated: whether the file states the rate.
        streams: width, height and codec of each video stream; the first is the one that is read.
        duration_is_stated: whether the header states ``seconds``; otherwise it is an estimate.
    """

    frames: int | None
    shown: int | None
    seconds: Fraction | None
    rate: Fraction
    rate_is_stated: bool
    streams: tuple[str, ...]
    duration_is_stated: bool

    @classmethod
    def from_decoder(cls, decoder: Decoder) -> HeaderInfo:
        """The statements of an open file's header."""
        stream = decoder.stream
        rate = stream.average_rate or stream.guessed_rate
        if stream.average_rate and not stream.duration and decoder.kind.demuxer in ("h264", "hevc"):
            rate = stream.codec_context.framerate  # the demuxer's own rate is a default
        seconds: Fraction | None = None
        if stream.duration:
            seconds = stream.duration * decoder.time_base
        elif len(decoder.container.streams) == 1 and decoder.container.duration:
            seconds = Fraction(decoder.container.duration, 1_000_000)
        frames = int(stream.frames) or None
        # The MP4 family has read its whole index by now; it omits groups of pictures that no edit shows.
        indexed = frames is not None and decoder.kind.demuxer == "mov"
        return cls(
            frames,
            len(stream.index_entries) if indexed else frames,
            seconds,
            Fraction(rate or 25),
            bool(rate),
            tuple(_describe_stream(each) for each in video_streams(decoder.container)),
            decoder.kind.states_length,
        )

    @property
    def count(self) -> int | None:
        """The announced number of frames, by duration if the number is not stated."""
        if self.frames is not None:
            return self.frames
        return None if self.seconds is None else round(self.seconds * self.rate)


@dataclass(frozen=True, slots=True)
class DecodeCounts:
    """Results of one pass over the whole file.

    Attributes:
        packets: number of coded pictures in the file.
        discarded: number of those that an edit list hides.
        untimed: number of those that the file shows for no time.
        failed: number of packets that could not be read or decoded.
        sizes: widths and heights of the decoded pictures, with the stamp of the first picture of each size.
    """

    packets: int
    discarded: int
    untimed: int
    failed: int
    sizes: dict[tuple[int, int], int]

    @classmethod
    def from_decoder(cls, decoder: Decoder) -> DecodeCounts:
        """The counts of a decoder that has read the whole file from its start."""
        return cls(decoder.packets, decoder.discarded, decoder.untimed, decoder.failed, dict(decoder.sizes))


@dataclass(frozen=True, slots=True)
class VideoInfo:
    """The facts for all sentences about a file.

    Attributes:
        path: the file.
        kind: kind of the file.
        header: statements of its header.
        layout: facts from its outermost boxes.
        counts: results of a whole pass.
        timeline: times of its frames.
        scan: its packets.
        table: its frames.
        pixel_ratio: width of a pixel divided by its height, upright.
        width: px of the upright picture.
        height: px of the upright picture.
    """

    path: Path
    kind: Kind
    header: HeaderInfo
    layout: ContainerLayout
    counts: DecodeCounts
    timeline: Timeline
    scan: Scan
    table: FrameTable
    pixel_ratio: Fraction
    width: int
    height: int

    def messages(self) -> tuple[str, ...]:
        """The warnings, losses first."""
        checks = (
            self._joined, self._short, self._leading, self._failed, self._damaged, self._repeated, self._streams,
            self._sizes, self._restarts, self._untimed, self._shape,
        )  # fmt: skip
        return tuple(f"{self.path.name} {message}" for check in checks if (message := check()))

    def _joined(self) -> str | None:
        starts, stated_frames, count = self.layout.starts, self.header.frames, len(self.table)
        if len(starts) == 1:
            return None
        joined = f"holds {len(starts)} videos joined end to end"
        last = int(self.scan.positions.max(initial=0))
        # an MP4 is read by its first index; its videos begin with their data or with their index
        read = 1 if self.kind.demuxer == "mov" else sum(start <= last for start in starts)
        if read < len(starts):
            which = "the first is" if read == 1 else f"the first {read} are"
            return (
                f"{joined}, of which only {which} read ({plural(count, 'frame')}). Split it, or join the videos "
                "with a tool that writes one index."
            )
        if stated_frames is not None and count > stated_frames:
            return f"{joined}: all {count} frames are read, though it announces {stated_frames}."
        return None

    def _short(self) -> str | None:
        header, counts, count = self.header, self.counts, len(self.table)
        if header.frames is not None and header.shown is not None and count < header.frames:
            promise = f"announces {header.frames} frames, {count} decode"
            if counts.packets + self._repeats() < header.shown:
                if self.kind.address == "position" and self.layout.is_complete:
                    return f"{promise} though the file is whole: its header is wrong, or the last ones are repeats."
                return f"{promise}: the file is cut short."
            if hidden := header.frames - header.shown + counts.discarded:
                return f"{promise}: its edit list hides {hidden}."
            lost = header.frames - count - counts.failed - self._undecodable_at_start() - self._repeats()
            if lost > 0:
                return f"{promise}: {plural(lost, 'picture')} {_is_or_are(lost)} lost to damage."
        elif header.frames is None and header.seconds is not None and header.duration_is_stated:
            end = self.table.time(count - 1) - self.table.time(0) + self.table.interval()
            if end + _DURATION_TOLERANCE_S < header.seconds:
                return f"announces {float(header.seconds):.1f} s, {float(end):.1f} s decode: the file is cut short."
        elif self.layout.is_complete is False:
            return f"ends before it is complete, {plural(count, 'frame')} decode: the file is cut short."
        return None

    def _undecodable_at_start(self) -> int:
        """Number of packets at the start whose pictures cannot be decoded because their references are missing."""
        scan, number = self.scan, np.arange(len(self.scan.stamps))
        keys = [*np.flatnonzero(scan.keys)[:2].tolist(), len(number)]
        if len(keys) == 1:
            return 0
        early = (number < keys[0]) | ((number < keys[1]) & (scan.ticks < scan.ticks[keys[0]]) & (scan.ticks != NO_TIME))
        return int(np.count_nonzero(early & ~np.isin(scan.stamps, self.table.stamps)))

    def _leading(self) -> str | None:
        lead_in = self._undecodable_at_start()
        if not lead_in:
            return None
        lost = f"its first {plural(lead_in, 'picture')} cannot be decoded and {_is_or_are(lead_in)} left out"
        return f"begins between key frames: {lost}."

    def _failed(self) -> str | None:
        failed = self.counts.failed
        return f"has {plural(failed, 'damaged packet')} that cannot be decoded." if failed else None

    def _damaged(self) -> str | None:
        damaged = int(self.table.corrupt.sum())
        return f"has {plural(damaged, 'frame')} with damage, or predicted from damage." if damaged else None

    def _repeats(self) -> int:
        """Number of empty chunks between the pictures of an AVI file; each shows the picture before it again.

        They are counted by the decoding times, which increase by one per chunk.
        """
        ticks = self.scan.ticks
        if self.kind.address != "position" or not len(ticks):
            return 0
        return max(0, int(ticks.max() - ticks.min()) + 1 - len(ticks))

    def _repeated(self) -> str | None:
        repeats = self._repeats()
        if not repeats:
            return None
        return (
            f"announces {self.header.frames} frames, of which {repeats} {_is_or_are(repeats)} "
            f"{'a repeat' if repeats == 1 else 'repeats'} of the picture before: such a picture is one frame that "
            "stays for longer."
        )

    def _streams(self) -> str | None:
        first, *others = self.header.streams
        if not others:
            return None
        return (
            f"has {len(others) + 1} video streams: the first is read ({first}), not {', '.join(others)}. Copy another "
            "one into a file of its own to read it."
        )

    def _sizes(self) -> str | None:
        if not self.counts.sizes:
            return None  # this pass decoded nothing
        first, *others = sorted((_frame_of(self.table, stamp), size) for size, stamp in self.counts.sizes.items())
        if not others:
            return None
        width, height = first[1]
        changes = _list_positions([f"{w}x{h} from frame {k} on" for k, (w, h) in others])
        return (
            f"changes the size of its pictures, {width}x{height} at first: {changes}. All are scaled to "
            f"{width}x{height}, and so are their coordinates."
        )

    def _restarts(self) -> str | None:
        positions = [f"at frame {k} (from {a:.3f} s to {b:.3f} s)" for k, a, b in self.timeline.restarts]
        if not positions:
            return None
        return (
            f"has times that run back {_list_positions(positions)}, as where files were joined: later frames are timed "
            "on from the frame before."
        )

    def _untimed(self) -> str | None:
        filled, untimed, count = self.timeline.filled, self.counts.untimed, len(self.table)
        rate_origin = (
            "as its header says" if self.header.rate_is_stated else "which is assumed, because it says no rate"
        )
        at = f"at {float(self.timeline.rate):g} frames a second, {rate_origin}"
        if filled and filled == count:
            return f"stores no times: its frames are timed {at}."
        if filled:
            return (
                f"has {plural(filled, 'frame')} without a time of {'its' if filled == 1 else 'their'} own, timed {at}."
            )
        if untimed and count > 1:
            stay = "stays" if untimed == 1 else "stay"
            return f"has {plural(untimed, 'picture')} that {stay} for no time: each gets a short one, as in players."
        return None

    def _shape(self) -> str | None:
        ratio = self.pixel_ratio
        if ratio == 1:
            return None
        return (
            f"has pixels that are not square ({ratio.numerator}:{ratio.denominator}): its {self.width}x{self.height} "
            f"pictures are shown as {round(self.width * ratio)}x{self.height}. Coordinates are those of "
            f"{self.width}x{self.height}."
        )


def _frame_of(table: FrameTable, stamp: int) -> int:
    """The first frame with a stamp."""
    return int(np.argmax(table.stamps == stamp))


def _describe_stream(stream: av.VideoStream) -> str:
    context = stream.codec_context
    return "one that cannot be decoded" if context is None else f"{context.width}x{context.height} {context.codec.name}"


def _list_positions(positions: list[str]) -> str:
    others = len(positions) - _MAX_LISTED
    return ", ".join(positions[:_MAX_LISTED]) + (f" and at {others} more" if others > 0 else "")


def _is_or_are(number: int) -> str:
    return "is" if number == 1 else "are"
