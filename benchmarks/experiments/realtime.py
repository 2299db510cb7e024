"""Compares the preset ``realtime`` with ``default``: time per frame at several sizes, and loss of signs."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np

from benchmarks.cache import cache_key, file_digest, table_digest
from benchmarks.experiment import Data, Experiment, Result
from benchmarks.experiments.first_sight import first_matches
from benchmarks.reporting.markdown import number, table
from benchmarks.timing.looped_video import RATE, SIZE, base_clip
from benchmarks.videos.approaches import EACH, read_approaches
from benchmarks.videos.clips import clip_groups, read_clips
from benchmarks.videos.tracked_clips import Videos
from sample_videos import SHIPPED
from tsr_engine.evaluation.track_tables import read_results
from tsr_engine.evaluation.tracking import VideoReport, evaluate_video, summarise
from tsr_engine.io.video import open_video
from tsr_engine.io.video_writer import VideoWriter
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params import Params
from tsr_engine.pipeline import Components, VideoDetector, load_components, one_opencv_thread
from tsr_engine.runs.track_video import Progress, RunRequest, track_video
from tsr_engine.track_table import TrackTable

SIZES = {"720x576": 25, "1280x720": 30, "1920x1080": 30, "3840x2160": 10}
"""Wanted frames per second on two cores, by size."""
FRAMES = 84
"""Number of frames of the drive for timing."""
STARTING = 12
"""Number of first frames that are not counted: they compile code and fill the decoder's queue."""
PASSING = 3.7
"""Time to pass a frame between two cores, ms (docs/scale.md)."""
PRESETS = ("default", "realtime")
LATER_START = 1
"""First frame of the runs that leave out frame 0, which is scanned whole."""


def _run(data: Data) -> Result:
    figures: JsonObject = {"times": _times(data.scratch / "realtime"), "price": {}}
    groups: dict[str, Videos] = {}
    if data.clips is not None and data.clips.is_dir():
        groups |= {f"clips {group}": own for group, own in clip_groups(read_clips(data.clips)).items()}
    if data.looming is not None and data.looming.is_dir():
        groups["approaches"] = read_approaches(data.looming, each=EACH).videos
    for group, videos in groups.items():
        figures["price"][group] = _cost(videos, data.scratch / "realtime", 0)
        figures["price"][f"{group}, from frame {LATER_START}"] = _cost(videos, data.scratch / "realtime", LATER_START)
    return Result(
        data=f"Time: the first {FRAMES} frames of the sample drive `{SHIPPED[0].video.stem}`, enlarged; CPU time of "
        "the whole process, median over frames. Cost in signs: "
        + ("; ".join(f"{name}: {len(videos)} videos" for name, videos in groups.items()) or "no annotated videos given")
        + ".",
        figures=figures,
        settings={"scan_turns": Params.preset("realtime").detector.scan_turns},
    )


def _times(folder: Path) -> JsonObject:
    """CPU ms per frame by size and preset."""
    folder.mkdir(parents=True, exist_ok=True)
    with one_opencv_thread():
        found: JsonObject = {}
        for size in SIZES:
            video = _enlarged(folder, size)
            decoding = _decoding(video)
            found[size] = {preset: _time(video, Params.preset(preset)) | decoding for preset in PRESETS}
        return found


def _enlarged(folder: Path, size: str) -> Path:
    """The sample drive in another size, made on first use."""
    width, height = (int(v) for v in size.split("x"))
    if (width, height) == SIZE:
        return base_clip(folder, FRAMES)
    path = folder / f"{size}.mp4"
    if not path.is_file():
        with VideoWriter(path, width, height, Fraction(RATE)) as writer, open_video(SHIPPED[0].video) as video:
            for frame in video.frames(0, FRAMES):
                writer.write(np.asarray(cv2.resize(frame.picture, (width, height), interpolation=cv2.INTER_CUBIC)))
    return path


def _decoding(video: Path) -> JsonObject:
    """Mean CPU ms per frame of decoding alone, including the threads that decode ahead."""
    with open_video(video) as opened:
        began = time.process_time()
        frames = sum(1 for _ in opened.frames(0, None))
        return {"decoding": round(1e3 * (time.process_time() - began) / frames, 2)}


def _time(video: Path, params: Params) -> JsonObject:
    """CPU ms per frame of the whole engine, and of detection in its thread."""
    params = params.with_settings([("second_core", False), ("coast_foe_y", 0.5)])
    components = load_components(params)
    whole = list(_whole(video, params, components))
    detector, detection = VideoDetector(components.detector, single_core=True), []
    with open_video(video) as opened:
        for frame in opened.frames(0, None):
            began = time.thread_time()
            detector.detect(frame.ordinal, frame.picture)
            detection.append(time.thread_time() - began)
    return {
        name: round(1e3 * steady_seconds(seconds[STARTING:], params.detector.scan_turns), 2)
        for name, seconds in (("whole", whole), ("detection", detection))
    }


def steady_seconds(seconds: list[float], turns: int) -> float:
    """Mean over the frames of a turn of the median over turns, since the frames of a turn have different work."""
    return float(np.mean([np.median(seconds[k::turns]) for k in range(turns)]))


def _whole(video: Path, params: Params, components: Components) -> Iterator[float]:
    """CPU seconds of the process for each frame of a run."""
    ticks = [time.process_time()]

    def after(_: Progress) -> None:
        ticks.append(time.process_time())

    track_video(RunRequest(video, params), components, progress=after)
    yield from np.diff(ticks).tolist()


def _cost(videos: Videos, folder: Path, start: int) -> JsonObject:
    """Figures of each preset on the signs of some videos, in runs from frame ``start`` on."""
    reports: dict[str, list[VideoReport]] = {}
    first_seen: dict[str, dict[tuple[str, int], tuple[int, float]]] = {}
    for name in PRESETS:
        params = Params.preset(name)
        components = load_components(params)
        for title, (video, whole) in videos.items():
            truth = whole.rows(whole.frame >= start)
            rows, frames, size = _tracked(title, video, truth, params, components, folder, start)
            reports.setdefault(name, []).append(evaluate_video(title, truth, rows, frames, size=size))
            seen = first_frames(truth, rows, frames, size)
            first_seen.setdefault(name, {}).update({(title, sign): first for sign, first in seen.items()})
    before = first_seen["default"]
    return {name: summarise(found).as_dict() | delays(before, first_seen[name]) for name, found in reports.items()}


def _tracked(
    title: str, video: Path, truth: TrackTable, params: Params, components: Components, folder: Path, start: int
) -> tuple[TrackTable, int, tuple[int, int]]:
    """Result rows of a run, number of frames and size of the pictures; rows of an earlier call are reused."""
    data = [title, file_digest(video), table_digest(truth), start]
    path = folder / f"{cache_key([*data, params.model_dump_json(), dict(components.models)])}.csv"
    if not path.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        track_video(RunRequest(video, params, csv=path, start=start), components)
    with open_video(video) as opened:
        return read_results(path), len(opened.table), (opened.width, opened.height)


def first_frames(
    truth: TrackTable, results: TrackTable, frames: int, size: tuple[int, int]
) -> dict[int, tuple[int, float]]:
    """Sign -> first frame in which a track lies on it, and the sign's width there, px."""
    matched = evaluate_video("", truth, results, frames, min_width=1.0, size=size).matched
    return first_matches(truth, matched)


def delays(
    before: Mapping[tuple[str, int], tuple[int, float]], now: Mapping[tuple[str, int], tuple[int, float]]
) -> JsonObject:
    """Delay of the first frame of signs, compared with ``default``."""
    both = sorted(before.keys() & now.keys())
    late = np.array([now[sign][0] - before[sign][0] for sign in both])
    widths = np.array([now[sign][1] for sign in both])
    return {
        "first_seen_width": None if not both else round(float(np.median(widths)), 1),
        "later_mean": None if not both else round(float(late.mean()), 2),
        "later_most": None if not both else int(late.max()),
        "lost": [[video, sign] for video, sign in sorted(before.keys() - now.keys())],
        "won": [[video, sign] for video, sign in sorted(now.keys() - before.keys())],
    }


def frames_a_second(times: JsonMapping) -> float:
    """Frames per second on two cores by the model of docs/scale.md: work that needs frames in order stays on one."""
    in_order = times["whole"] - times["detection"] - times["decoding"]
    return float(1e3 / (max(times["whole"] / 2, in_order) + PASSING))


def _report(result: Result) -> str:
    head = ["CPU ms a frame", "preset", "decoding", "detection", "whole engine"]
    rows = [[*head, "frames/s of two cores", "wanted"]]
    for size, wanted in SIZES.items():
        for preset, ms in result.figures["times"][size].items():
            rate = frames_a_second(ms)
            rows.append([
                size, preset, *(f"{ms[part]:.1f}" for part in ("decoding", "detection", "whole")),
                f"{rate:.0f}", f"{wanted} ({'met' if rate >= wanted else '**missed**'})",
            ])  # fmt: skip
    text = (
        table(rows)
        + "\n*Frames/s of two cores* is computed from the CPU times of a frame: half of the whole, or the whole "
        "without decoding and detection if that is longer, because it takes the frames in order, plus "
        f"{PASSING} ms (docs/scale.md). *Realtime* searches the "
        f"smallest signs in {result.settings['scan_turns'] - 1} strips, one a frame, and all larger ones in a further "
        "frame. It detects signs that have a track in every frame. It scans frame 0 whole, and most of these videos "
        f"begin with their signs in view. The tables *from frame {LATER_START}* leave it out: they show how much later "
        "a sign is found that comes into view during a drive.\n"
    )
    return text + "".join(_report_cost(group, found) for group, found in result.figures["price"].items())


def _report_cost(group: str, found: JsonMapping) -> str:
    head = ["", "signs found", "false tracks", "coverage", "ids per sign", "mean Eq. 7", "right class"]
    rows = [[*head, "first seen at, median px", "later than `default`, frames: mean, most"]]
    notes = []
    for name, f in found.items():
        rows.append([
            name, f"{f['signs_detected']} of {f['signs']}", str(f["false_tracks"]), _share(f["coverage"]),
            number(f["ids_per_sign"], 2), number(f["mean_error"], 4), str(f["signs_classified"]),
            number(f["first_seen_width"], 1), f"{number(f['later_mean'], 2)}, {f['later_most']}",
        ])  # fmt: skip
        for how in ("lost", "won"):
            notes += [f"- {name}: {how} sign {sign} of {video}.\n" for video, sign in f[how]]
    return f"\n**{group[0].upper()}{group[1:]}**\n\n" + table(rows) + ("\n" + "".join(notes) if notes else "")


def _share(value: float | None) -> str:
    return "-" if value is None else f"{100 * value:.1f} %"


def _headline(result: Result) -> str:
    return "; ".join(
        f"{size}: whole engine {presets['realtime']['whole']:.0f} ms ({presets['default']['whole']:.0f} with `default`)"
        for size, presets in result.figures["times"].items()
    )


EXPERIMENT = Experiment(
    "realtime",
    "Real time",
    "How many frames a second does the preset `realtime` process, and how many signs does it cost?",
    _run,
    _report,
    headline=_headline,
    optional=("clips", "looming"),
)
