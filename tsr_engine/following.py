"""Follows a sign through a video file, for the command and the review tool."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from tsr_engine.detection.refine.window_rescoring import WindowRescoring
from tsr_engine.follow import Anchor, Direction, Event, FollowerModels, follow
from tsr_engine.io.both_ways import BothWays
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video import FrameTable, VideoLimits, open_video
from tsr_engine.params import Params
from tsr_engine.pipeline import load_detector, load_online, one_blas_thread

__all__ = ["follow_video", "load_follower"]


def load_follower(folder: Path | None = None) -> FollowerModels:
    """The trained parts that following rests on.

    Args:
        folder: of models; unset: those shipped with the package.

    Raises:
        ModelError: a component is missing, damaged, or of another version.
    """
    params = Params()
    detector = load_detector(params, folder)
    look = WindowRescoring(detector.model, detector.box_inset, params.detector.refine_passes)
    return FollowerModels(load_online(params, folder), look)


def follow_video(
    path: VideoSource | str,
    anchors: Sequence[Anchor],
    parts: FollowerModels,
    *,
    direction: Direction | None = None,
    first: int = 0,
    last: int | None = None,
    between: bool = False,
    table: FrameTable | None = None,
    limits: VideoLimits | None = None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Iterator[Event]:
    """Follow one sign through a video file; see :func:`tsr_engine.follow.follow` for what comes out.

    At most about 150 MB of pictures are held, however long the video is. Closing the iterator closes the file.

    Args:
        path: the video, or whoever opens it.
        anchors: one or more boxes of the sign, of different frames.
        parts: of :func:`load_follower`; one call at a time may use them.
        direction: the only one to follow beyond the anchors; unset: both.
        first: no frame before this one is looked at.
        last: no frame after this one is looked at; unset: to the end of the video.
        between: only the frames between the outermost anchors.
        table: the file's frame table from an earlier pass: makes random access fast at once.
        limits: what the file may demand; unset: ``VideoLimits()``.
        cancelled: asked before each frame; true ends it.

    Yields:
        Proposals and endings.

    Raises:
        UsageError: an anchor cannot be followed; raised before any proposal.
        VideoError: the file cannot be opened or decoded, or is not that of its table.
    """
    with open_video(path, limits=limits, table=table) as video, BothWays(video) as pictures, one_blas_thread():
        yield from follow(
            pictures,
            anchors,
            parts,
            direction=direction,
            first=first,
            last=last,
            between=between,
            cancelled=cancelled,
        )
