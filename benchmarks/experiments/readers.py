"""What reads signs: the classifier, the network, or both together, at annotated boxes."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, get_args

import numpy as np

from benchmarks.experiment import Data, Experiment, Result, Skip
from benchmarks.experiments.other_shapes import read_boxes
from benchmarks.reporting.markdown import table
from benchmarks.timing.alternating import pipeline_beside
from benchmarks.timing.looped_video import base_clip
from benchmarks.videos.clips import read_clips
from tsr_engine.io.gtsdb import read_gtsdb
from tsr_engine.io.models import load_component
from tsr_engine.io.pictures import read_picture
from tsr_engine.io.video import open_video
from tsr_engine.json_shapes import JsonObject
from tsr_engine.params import Params, Reader
from tsr_engine.pipeline import READER_COMPONENTS, load_components, load_reader, one_blas_thread, one_opencv_thread
from tsr_engine.protocols import CropClassifier
from tsr_engine.recognition.crops import cut
from tsr_engine.recognition.fusion import Fusion
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.public.detector_components import split_scenes

READERS: Final[tuple[Reader, ...]] = get_args(Reader)
TIMED: Final = 300
"""Crops that are read one by one, by each reader in turn."""
WIDTH: Final = 20
"""Least width of a sign in a clip, px."""
FRAMES: Final = 132
"""Of the sample drive, for the whole engine."""
ROUNDS: Final = 3
"""Runs of it with each reader."""
MIN_PROBABILITY: Final = 1e-12
"""Least probability of the truth in a log-likelihood."""


@dataclass(frozen=True, slots=True)
class Crop:
    """A sign in one picture, cut at its annotated box with the border that readers want.

    Attributes:
        sign: a name for the physical sign, which the pictures of one clip share.
        class_id: the truth, 0 to 42.
        side: of the box, px (geometric mean of width and height).
        pixels: BGR.
    """

    sign: str
    class_id: int
    side: float
    pixels: Picture


def figures_of(crops: Sequence[Crop], reader: CropClassifier) -> JsonObject:
    """What a reader makes of crops.

    Returns:
        ``crops``, ``right`` and ``likelihood`` (the mean negative log-likelihood) over single crops; ``signs`` and
        ``signs_right`` with the votes of a sign fused as in a run; ``misread`` with a row a sign that is not right.
    """
    answers = np.concatenate([reader.probabilities([crop.pixels]) for crop in crops]).astype(np.float64)
    truth = np.array([crop.class_id for crop in crops])
    states: dict[str, Fusion] = {}
    read: dict[str, int] = {}
    for crop, row in zip(crops, answers, strict=True):
        before = states.get(crop.sign) or Fusion.start(Params().fusion, len(row))
        states[crop.sign], record = before.update(row, crop.side)
        read[crop.sign] = record.class_id
    of_sign = {crop.sign: crop.class_id for crop in crops}
    misread = [
        {"sign": sign, "class": of_sign[sign], "read": got} for sign, got in read.items() if got != of_sign[sign]
    ]
    own = answers[np.arange(len(truth)), truth]
    return {
        "crops": len(crops),
        "right": int((answers.argmax(axis=1) == truth).sum()),
        "likelihood": float(-np.log(np.maximum(own, MIN_PROBABILITY)).mean()),
        "signs": len(of_sign),
        "signs_right": len(of_sign) - len(misread),
        "misread": misread,
    }


def _run(data: Data) -> Result:
    readers: dict[Reader, CropClassifier] = {name: load_reader(reader=name) for name in READERS}
    margin = readers["both"].margin
    sets = {name: list(crops) for name, crops in _sets(data, margin)}
    if not sets:
        raise Skip("no data: none of the folders `clips`, `foreign` and `gtsdb` was given.")
    with one_blas_thread():
        figures = {
            name: {reader: figures_of(crops, reads) for reader, reads in readers.items()}
            for name, crops in sets.items()
        }
        times = _times([crop.pixels for crops in sets.values() for crop in crops], readers)
    engine, in_view = engine_times(base_clip(data.scratch / "looped", FRAMES))
    return Result(
        data="Signs of the 43 classes, cropped at their annotated boxes. Annotated clips: every frame from "
        f"{WIDTH} px on, with the votes of a sign fused. Pictures of other cameras: upright signs from 20 px on. "
        "GTSDB: the scenes that training reports on. Classifier and network were trained on GTSRB, whose tracks come "
        "from the recordings of GTSDB. The reader `both` weights them equally; nothing was chosen on these data.",
        figures={"sets": figures, "crop_ms": times, "engine_ms": engine, "signs_in_view": in_view},
        settings={name: load_component(name).sha256[:12] for name in READER_COMPONENTS},
    )


def _sets(data: Data, margin: float) -> Iterator[tuple[str, Iterator[Crop]]]:
    if data.clips is not None:
        yield "clips", _of_clips(data, margin)
    for folder in sorted(data.foreign.iterdir() if data.foreign is not None else ()):
        if (folder / "boxes.json").is_file():
            yield (
                folder.name,
                (
                    _crop(f"{name} {number}", sign.class_id, read_picture(folder / name), sign.box, margin)
                    for name, signs in read_boxes(folder).items()
                    for number, sign in enumerate(signs)
                    if sign.kind == "43"
                ),
            )
    if data.gtsdb is not None:
        report = split_scenes(read_gtsdb(data.gtsdb), int(load_component("detector").seed or 0))[2]
        yield (
            "gtsdb, scenes of the report",
            (
                _crop(f"{scene.name} {number}", int(label), read_picture(scene.path), box, margin)
                for scene in report
                for number, (box, label) in enumerate(zip(scene.boxes, scene.class_ids, strict=True))
            ),
        )


def _of_clips(data: Data, margin: float) -> Iterator[Crop]:
    """Every frame of every annotated sign that counts and is not cut by the picture's edge."""
    for name, (path, truth) in read_clips(data.need("clips")).items():
        wide = truth.boxes[:, 2] - truth.boxes[:, 0] >= WIDTH
        rows = np.flatnonzero(wide & ~truth.ignore & (truth.class_id >= 0))
        of_frame: dict[int, list[int]] = {}
        for row in rows.tolist():
            of_frame.setdefault(int(truth.frame[row]), []).append(row)
        with open_video(path) as video:
            for frame in video.frames(0, 1 + max(of_frame, default=-1)):
                for row in of_frame.get(frame.ordinal, ()):
                    sign = f"{name} {truth.track[row]}"
                    yield _crop(sign, int(truth.class_id[row]), frame.picture, truth.boxes[row], margin)


def _crop(sign: str, class_id: int, picture: Picture, box: FloatArray, margin: float) -> Crop:
    side = float(np.sqrt((box[2] - box[0]) * (box[3] - box[1])))
    return Crop(sign, class_id, side, cut(picture, box, margin))


def _times(crops: Sequence[Picture], readers: Mapping[Reader, CropClassifier]) -> dict[str, float]:
    """Median CPU time of reading one crop that is cut out already, ms."""
    taken: dict[str, list[float]] = {name: [] for name in readers}
    for pixels in crops[:: max(1, len(crops) // TIMED)]:
        for name, reads in readers.items():
            began = time.thread_time()
            reads.probabilities([pixels])
            taken[name].append(time.thread_time() - began)
    return {name: round(1e3 * float(np.median(each)), 3) for name, each in taken.items()}


def engine_times(video: Path) -> tuple[dict[str, float], float]:
    """Median CPU time of a frame in the whole engine by reader, ms, and signs in view on average."""
    taken: dict[Reader, list[float]] = {reader: [] for reader in READERS}
    in_view = 0.0
    with one_opencv_thread():
        for _ in range(ROUNDS):
            for reader in READERS:
                params = Params().with_settings([("second_core", False), ("reader", reader)])
                found = pipeline_beside(video, params, load_components(params), {})
                in_view = found.signs_in_view
                taken[reader] += found.ms["whole engine"]
    return {reader: round(float(np.median(each)), 2) for reader, each in taken.items()}, in_view


def _report(result: Result) -> str:
    rows = [["signs", "reader", "single crops", "signs", "mean negative log-likelihood"]]
    for name, found in result.figures["sets"].items():
        for reader in READERS:
            one = found[reader]
            rows.append([
                name, reader, f"{one['right']} of {one['crops']}", f"{one['signs_right']} of {one['signs']}",
                f"{one['likelihood']:.4f}",
            ])  # fmt: skip
    times, whole = (
        ", ".join(f"{ms:.{digits}f} ms ({reader})" for reader, ms in result.figures[name].items())
        for name, digits in (("crop_ms", 2), ("engine_ms", 1))
    )
    return (
        f"{table(rows)}\nA crop takes one thread {times} (medians of CPU time; the readers take turns). A frame of "
        f"720x576 takes the whole engine {whole}, with {result.figures['signs_in_view']:.2f} signs in view on average "
        f"(first {FRAMES} frames of `country_road`, {ROUNDS} rounds in which the readers take turns). The default is "
        f"`{Params().pipeline.reader}`.\n"
    )


EXPERIMENT = Experiment(
    "readers",
    "Reading by classifier and network together",
    "Do the classifier and the network together classify better than either alone?",
    _run,
    _report,
    optional=("clips", "foreign", "gtsdb"),
)
