"""Runs the engine on the clip of a bundle."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from tsr_engine.bundle.clip import picture_digest
from tsr_engine.bundle.load import Bundle
from tsr_engine.errors import VideoError
from tsr_engine.evidence import FramePixels
from tsr_engine.io.video import VideoLimits, open_video
from tsr_engine.params import Params
from tsr_engine.pipeline import Components, FrameInput, TrackingCore, VideoDetector
from tsr_engine.records import FrameEvidence
from tsr_engine.tracking.camera_shift import CameraShift


@dataclass(slots=True)
class Decoding:
    """Results of decoding the clip.

    Attributes:
        frames: number of decoded pictures.
        other_pictures: number of those that differ from the pictures of which the bundle was made.
    """

    frames: int = 0
    other_pictures: int = 0


def run_engine(
    bundle: Bundle,
    params: Params,
    components: Components,
    decoding: Decoding,
    *,
    limits: VideoLimits | None = None,
    progress: Callable[[int, int], None] = lambda _done, _of: None,
) -> Iterator[FrameEvidence]:
    """Run the engine on every frame of the bundle, including the lead-in.

    Frame numbers and times, the nominal interval and the first track's number are those of the run, so that equal
    pictures, parameters and models give equal evidence.

    Args:
        bundle: the bundle.
        params: parameters of the replay.
        components: the trained components.
        decoding: filled while frames are decoded.
        limits: limits on the clip.
        progress: called with (frames done, total).

    Raises:
        VideoError: the clip cannot be decoded, is too short, or has pictures of another size.
    """
    manifest = bundle.manifest
    with open_video(bundle.clip, limits=limits) as video:
        if (video.width, video.height) != (manifest.clip.width, manifest.clip.height):
            raise VideoError(
                f"{manifest.clip.file} of {bundle.name} has pictures of {video.width}x{video.height}, expected "
                f"{manifest.clip.width}x{manifest.clip.height}. Create the bundle again."
            )
        core = TrackingCore(
            params,
            components.parts,
            video.width,
            video.height,
            interval=manifest.run.interval,
            first_id=manifest.frames.first_id,
        )
        detector, tracking = VideoDetector(components.detector), params.tracking
        shift_estimator = CameraShift(tracking.shift_scale, (tracking.foe_x, tracking.foe_y))
        pictures = video.frames(bundle.frames[0].clip, bundle.frames[-1].clip + 1)
        for wanted, frame in zip(bundle.frames, pictures, strict=False):
            decoding.other_pictures += picture_digest(frame.picture) != wanted.digest
            detections = detector.detect(wanted.ordinal, frame.picture)
            camera_shift = shift_estimator.step(frame.picture) if tracking.use_camera_shift else (0.0, 0.0)
            pixels = FramePixels(frame.picture)
            revisit = detector.revisit(frame.picture, detections)
            yield core.step(FrameInput(wanted.ordinal, wanted.seconds, detections, camera_shift, pixels, revisit))
            decoding.frames += 1
            progress(decoding.frames, len(bundle.frames))
    if decoding.frames != len(bundle.frames):
        raise VideoError(
            f"{manifest.clip.file} of {bundle.name} ends after {decoding.frames} of {len(bundle.frames)} frames. "
            "Copy the bundle again."
        )
