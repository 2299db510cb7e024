"""Follows a sign through a video file, for the command and the review tool."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from tsr_engine.detection.refine.window_rescoring import WindowRescoring
from tsr_engine.follow import Anchor, Direction, Event, FollowerModels, follow
from tsr_engine.io.bidirectional_frames import BidirectionalFrames
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video import FrameTable, VideoLimits, open_video
from tsr_engine.params import Params
from tsr_engine.pipeline import load_detector, load_online, one_blas_thread


def load_follower(folder: Path | None = None) -> FollowerModels:
    """Load the models that following needs.

    Args:
        folder: model folder; unset: the models of the package.

    Raises:
        ModelError: a component is missing, damaged, or of another version.
    """
    params = Params()
    detector = load_detector(params, folder)
    window_scorer = WindowRescoring(detector.model, detector.box_inset, params.detector.refine_passes)
    return FollowerModels(load_online(params, folder), window_scorer)


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
    """Follow one sign through a video file with :func:`tsr_engine.follow.follow`.

    Holds at most about 150 MB of pictures, whatever the length of the video. Closing the iterator closes the file.

    Args:
        path: path of the video, or an object that opens it.
        anchors: one or more boxes of the sign, in different frames.
        parts: result of :func:`load_follower`; not to be shared by concurrent calls.
        direction: direction to follow beyond the anchors; unset: both.
        first: first frame to read.
        last: last frame to read; unset: the end of the video.
        between: read only the frames between the outermost anchors.
        table: frame table of the file from an earlier pass; random access is then fast from the start.
        limits: limits on the file; unset: ``VideoLimits()``.
        cancelled: called before each frame; stops the iteration if it returns true.

    Yields:
        Proposals and endings.

    Raises:
        UsageError: an anchor cannot be followed; raised before any proposal.
        VideoError: the file cannot be opened or decoded, or does not match its table.
    """
    with (
        open_video(path, limits=limits, table=table) as video,
        BidirectionalFrames(video) as pictures,
        one_blas_thread(),
    ):
        yield from follow(
            pictures, anchors, parts, direction=direction, first=first, last=last, between=between, cancelled=cancelled
        )
