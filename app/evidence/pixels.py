"""Crops under boxes, and verdicts computed again from them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from app.errors import NotFound
from app.evidence.crops import MARGIN, CropOf, box_in_frame, crop_of, encode, pixels_in_frame
from app.evidence.explain import Explanation
from app.evidence.explainer import Explainer, ExplainRequest
from app.evidence.service import EvidenceService
from app.evidence.stored_run import StoredRun
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Video
from app.videos.checked_file import library_file
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.geometry.boxes import area, clip
from tsr_engine.records import FloatArray, Picture

Box = tuple[float, float, float, float]


class RunPixels:
    """Reads the stored pixels of runs, and decodes missing ones; thread-safe."""

    def __init__(self, settings: Settings, database: Database, evidence: EvidenceService) -> None:
        self._settings = settings
        self._database = database
        self._evidence = evidence
        self.explainer = Explainer()

    def close(self) -> None:
        """End the process of the explainer."""
        self.explainer.close()

    def crop(
        self, run_id: str, track_id: int, frame: int, size: int, of: CropOf, picture: Callable[[str, int], Picture]
    ) -> bytes:
        """Crop a track in a frame as PNG.

        Args:
            run_id: the run.
            track_id: the track.
            frame: ordinal of the frame.
            size: longer side of the crop, px.
            of: the track's result, or the prediction that the gate judged, with the gate's margin.
            picture: decodes a frame of a video; called only if the evidence lacks pixels.

        Raises:
            NotFound: the track has no such box in the frame.
        """
        run = self._evidence.stored_run(run_id)
        with self._evidence.reading(run) as reader:
            box = box_in_frame(reader, track_id, frame, of)
            margin = float(reader.header.parameters["gate"]["gate_margin"]) if of == "prediction" else MARGIN
        if box is None:
            raise NotFound(f"Track {track_id} has no {of} in frame {frame}.")
        return self._crop(run, frame, box, margin, size, picture)

    def crop_of_box(
        self, run_id: str, frame: int, box: Box, size: int, picture: Callable[[str, int], Picture]
    ) -> bytes:
        """Crop any box in a frame of the run's video, with the margin of a result, as PNG.

        Args:
            run_id: the run.
            frame: ordinal of the frame.
            box: x1, y1, x2, y2, px.
            size: longer side of the crop, px.
            picture: decodes a frame of a video; called only if the evidence lacks pixels.

        Raises:
            NotFound: the box lies outside the picture.
        """
        run = self._evidence.stored_run(run_id)
        with self._database.read() as session:
            video = session.get_one(Video, run.video_id)
        inside = clip(np.array([box], np.float64), video.width or 0, video.height or 0)
        if area(inside)[0] <= 0:
            raise NotFound("The box lies outside the picture.", field="box")
        return self._crop(run, frame, inside[0], MARGIN, size, picture)

    def _crop(
        self,
        run: StoredRun,
        frame: int,
        box: FloatArray,
        margin: float,
        size: int,
        picture: Callable[[str, int], Picture],
    ) -> bytes:
        with self._pixels_of(run) as source:
            stored = pixels_in_frame(source, frame)
        crop = crop_of(stored, box, margin, lambda: picture(run.video_id, frame))
        return encode(crop, size)

    def explain(self, run_id: str, track_id: int, frame: int) -> Explanation:
        """Explain the gate's verdict on one prediction.

        Raises:
            NotFound: the gate did not judge the track in that frame.
        """
        run = self._evidence.stored_run(run_id)
        not_judged = NotFound(f"The gate gave no verdict on track {track_id} in frame {frame}.")
        with self._evidence.reading(run) as reader, self._pixels_of(run) as source:
            if box_in_frame(reader, track_id, frame, "prediction") is None:
                raise not_judged  # also if the run has no such frame
            pixels = source.folder
        with self._database.read() as session:
            file = library_file(self._settings, session.get_one(Video, run.video_id))
        request = ExplainRequest(
            str(run.folder),
            str(pixels),
            str(file) if file.exists else "",
            track_id,
            frame,
            self._settings.max_pixels,
            file.digest or "",
            file.stamp,
            tuple(map(str, file.roots)),
        )
        explanation = self.explainer.explain(request)
        if explanation is None:
            raise not_judged
        return explanation

    @contextmanager
    def _pixels_of(self, run: StoredRun) -> Iterator[EvidenceReader]:
        """The store with the pixels; for a what-if, that of the run that it replays."""
        if run.parent_id is None:
            with self._evidence.reading(run) as reader:
                yield reader
            return
        with self._pixels_of(self._evidence.stored_run(run.parent_id)) as reader:
            yield reader
