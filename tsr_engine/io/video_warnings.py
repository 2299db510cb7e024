"""What is wrong with a video that nevertheless decodes, in one sentence each."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from tsr_engine.io.video_decoder import Decoder

# Containers without a frame count announce a duration, which muxers round and sound tracks stretch.
_TOLERANCE = Fraction(1, 2)


@dataclass(frozen=True, slots=True)
class Announced:
    """What the header promises; never trusted, only compared.

    Attributes:
        frames: number of coded pictures, None where the container does not say.
        shown: those of them that the container's index leads to once edit lists have hidden others.
        seconds: duration of the video stream, None where the container does not say.
        rate: average frames per second.
    """

    frames: int | None
    shown: int | None
    seconds: Fraction | None
    rate: Fraction

    @classmethod
    def of(cls, decoder: Decoder) -> Announced:
        """The promises of an open file's header."""
        stream = decoder.stream
        rate = Fraction(stream.average_rate or stream.guessed_rate or 25)
        seconds: Fraction | None = None
        if stream.duration:
            seconds = stream.duration * decoder.time_base
        elif len(decoder.container.streams) == 1 and decoder.container.duration:
            seconds = Fraction(decoder.container.duration, 1_000_000)
        frames = int(stream.frames) or None
        # Only the MP4 family has read its whole index by now; it omits groups of pictures that no edit shows.
        indexed = frames is not None and "mp4" in decoder.container.format.name
        return cls(frames, len(stream.index_entries) if indexed else frames, seconds, rate)

    @property
    def count(self) -> int | None:
        """The announced number of frames, by duration where it is not said."""
        if self.frames is not None:
            return self.frames
        return None if self.seconds is None else round(self.seconds * self.rate)


@dataclass(frozen=True, slots=True)
class Found:
    """What one pass over the whole file found.

    Attributes:
        packets: coded pictures in the file.
        discarded: those of them that an edit list hides.
        failed: packets that could not be read or decoded.
    """

    packets: int
    discarded: int
    failed: int

    @classmethod
    def of(cls, decoder: Decoder) -> Found:
        """The counts of a decoder that has read the whole file from its start."""
        return cls(decoder.packets, decoder.discarded, decoder.failed)


def describe(
    path: Path, announced: Announced, found: Found, count: int, end: Fraction, damaged: int
) -> tuple[str, ...]:
    """The warnings about one file.

    Args:
        path: the file.
        announced: what its header promises.
        found: what a whole pass found.
        count: frames that decode.
        end: from the start of the first frame to the end of the last, in seconds.
        damaged: frames with the corrupt flag.
    """
    sentences = []
    promise = f"{path.name} announces {announced.frames} frames, {count} decode"
    if announced.frames is not None and announced.shown is not None and count < announced.frames:
        if found.packets < announced.shown:
            sentences.append(f"{promise}: the file is cut short.")
        elif hidden := announced.frames - announced.shown + found.discarded:
            sentences.append(f"{promise}: its edit list hides {hidden}.")
        elif lost := announced.frames - count - found.failed:
            sentences.append(f"{promise}: {_some(lost, 'picture')} {'is' if lost == 1 else 'are'} lost to damage.")
    elif announced.frames is None and announced.seconds is not None and end + _TOLERANCE < announced.seconds:
        sentences.append(
            f"{path.name} announces {float(announced.seconds):.1f} s, {float(end):.1f} s decode: the file is cut short."
        )
    if found.failed:
        sentences.append(f"{path.name} has {_some(found.failed, 'damaged packet')} that cannot be decoded.")
    if damaged:
        sentences.append(f"{path.name} has {_some(damaged, 'frame')} with damage, or predicted from damage.")
    return tuple(sentences)


def _some(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"
