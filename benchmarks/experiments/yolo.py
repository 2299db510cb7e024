"""YOLO11n, trained on a GPU on the scenes of our detector, with the trackers of today: what people would pick."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from benchmarks.cache import Cache
from benchmarks.deep.train_yolo import NAME, SIZE
from benchmarks.experiment import Data, Experiment, Result, Skip
from benchmarks.experiments.deep import detect_scenes, plug_in, scene_figures
from benchmarks.experiments.other_shapes import RATE, counts, read_boxes
from benchmarks.experiments.trackers import CHOSEN_ON, annotated_videos, figures_by_group, run_peers
from benchmarks.reporting.markdown import number, table
from benchmarks.reporting.plotting import draw_precision_recall
from benchmarks.systems.held_out_scenes import ACF_IS, DetectionResults, held_out
from benchmarks.videos.engine_tracker import track_with_engine
from benchmarks.videos.stored_detections import detect_videos
from tsr_engine.evaluation.detection import match, score_detections
from tsr_engine.geometry.boxes import non_overlap_each
from tsr_engine.io.pictures import read_picture
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params import Params
from tsr_engine.pipeline import Network, load_components, load_detector, one_opencv_thread
from tsr_engine.protocols import OfflineDetector
from tsr_engine.track_table import TrackTable

YOLO: Final = "YOLO11n"
ACF: Final = "ACF"
OURS: Final = "our engine"
OURS_ON_YOLO: Final = "our tracking on YOLO11n's boxes"
MIN_SCORE: Final = -6.9
"""Log-odds from which the network's detections are kept: a confidence of 0.001, as Ultralytics evaluates."""
BOX_RATE: Final = 0.1
"""False detections a picture from which on the boxes of found signs are compared."""


def _run(data: Data) -> Result:
    path = data.scratch / "yolo" / f"{NAME}.onnx"
    about = path.with_suffix(".json")
    if not path.is_file() or not about.is_file():
        raise Skip(
            f"there is no trained network; `python -m benchmarks.deep.train_yolo {path.parent} --gtsdb GTSDB` makes it "
            "(needs a GPU and the extra `bench`)."
        )
    digest = hashlib.sha256(path.read_bytes()).hexdigest()[:12]
    known = held_out(data)
    with one_opencv_thread():
        network = plug_in(path, SIZE, min_score=MIN_SCORE)
        found = {ACF: known.detections(prior=False), YOLO: detect_scenes(network, known.report)}
        detectors: dict[str, OfflineDetector] = {ACF: load_detector(Params()), YOLO: network}
        folders = sorted(data.foreign.iterdir()) if data.foreign is not None else []
        foreign = {
            folder.name: {name: _foreign(detector, folder) for name, detector in detectors.items()}
            for folder in folders
            if (folder / "boxes.json").is_file()
        }
        groups, chosen, missing = _tracking(data, Network(path, SIZE), path.parent / digest)
    return Result(
        data=f"GTSDB, split by scene as for *Detection on unseen scenes*: {len(known.report)} scenes are reported on, "
        "which neither detector has seen. Neither has seen the annotated clips or the pictures of other cameras.",
        figures={
            "scenes": {name: {**scene_figures(r), "error": error_at_rate(r)} for name, r in found.items()},
            "foreign": foreign,
            "groups": groups,
            "chosen": chosen,
            "missing": missing,
            "training": json.loads(about.read_text(encoding="utf-8")),
        },
        settings={"network": digest, "input": "x".join(map(str, SIZE)), "detector": known.detector.sha256[:12]},
    )


def error_at_rate(results: DetectionResults) -> float:
    """Mean Eq. 7 of the signs that are found at ``BOX_RATE``."""
    least = score_detections(results).threshold_at(BOX_RATE)
    errors = []
    for boxes, scores, truth in results:
        kept = scores >= least
        _, by = match(boxes[kept], scores[kept], truth)
        errors.append(non_overlap_each(boxes[kept][by[by >= 0]], truth[by >= 0]))
    return float(np.concatenate(errors).mean())


def _foreign(detector: OfflineDetector, folder: Path) -> JsonObject:
    rows = []
    for name, signs in read_boxes(folder).items():
        seen = detector.detect(read_picture(folder / name))
        rows.append((signs, seen.boxes, seen.raw_scores))
    return dict(counts(rows))


def _tracking(data: Data, network: Network, store: Path) -> tuple[JsonObject, JsonObject, dict[str, str]]:
    """Figures of our engine and of trackers on the network's boxes; the settings chosen; peers that cannot run."""
    params = Params.preset("default")
    ours, theirs = load_components(params), load_components(params, network=network)
    # Approaches are made of photographs that both detectors may have seen in training.
    videos, _ = annotated_videos(replace(data, looming=None))
    judged = [v for v in videos if v.group not in CHOSEN_ON]
    seen_by_ours = list(detect_videos(judged, data.scratch / "detections", ours))
    seen = list(detect_videos(videos, store / "detections", theirs))
    seen_judged = [s for s in seen if s.video.group not in CHOSEN_ON]
    cache = Cache(store / "peers")
    rows: dict[str, list[tuple[TrackTable, float]]] = {OURS: [], OURS_ON_YOLO: []}
    for name, videos_of, parts, kept in (
        (OURS, seen_by_ours, ours, Cache(data.scratch / "peers")),
        (OURS_ON_YOLO, seen_judged, theirs, cache),
    ):
        for video in videos_of:
            tracked = track_with_engine(video, {"default": (params, parts)}, kept)["default"]
            rows[name].append((tracked.rows, tracked.seconds))
    chosen, missing = run_peers([s for s in seen if s.video.group in CHOSEN_ON], seen_judged, rows, cache)
    return figures_by_group(seen_judged, rows), chosen, missing


def _report(result: Result) -> str:
    f = result.figures
    widths = list(f["scenes"][ACF]["by_width"])
    rows = [
        ["", "AP", "recall at 0.03 false a picture", "at 0.1", "at 1",
         *(f"{w} px".replace("-1000", " and more") for w in widths), "mean Eq. 7"]
    ]  # fmt: skip
    for name in (ACF, YOLO):
        s = f["scenes"][name]
        recalls = (number(s["recall_at"][rate], 3) for rate in ("0.03", "0.1", "1.0"))
        by_width = (f"{hit}/{signs}" for hit, signs in s["by_width"].values())
        rows.append([name, number(s["ap"], 4), *recalls, *by_width, number(s["error"], 3)])
    t = f["training"]
    return (
        f"{table(rows)}{ACF_IS}\nThe columns of widths count the signs found at {BOX_RATE} false detections a "
        "picture; *mean Eq. 7* is of the boxes of these signs.\n\n"
        f"YOLO11n ({t['parameters']:,} parameters) was trained from random weights by Ultralytics {t['ultralytics']} "
        f"with its own recipe (mosaic, mirroring, colours, scale), {t['epochs']} epochs in {t['minutes']} minutes on "
        f"one {t['device']}, with pictures of {SIZE[0]} px and a step for each batch of 16. It had the {t['scenes']} "
        f"scenes ({t['signs']} signs) that ours was trained and calibrated on, all classes as one. Ours also had the "
        "crops of GTSRB. Weights trained on hundreds of thousands of other pictures, from which people usually start, "
        "were not available here; they would help the network most where its training has few examples.\n\n"
        + _foreign_table(f["foreign"])
        + "".join(_group_table(group, by_name) for group, by_name in f["groups"].items())
        + "".join(f"*Skipped:* {name}: {why}\n\n" for name, why in f["missing"].items())
        + "The trackers' settings were chosen by HOTA on the other clips, with YOLO11n's boxes, as for *Trackers on "
        "identical detections*. Our parameters were chosen on the same other clips, but these three were looked at "
        "often while the engine was built. *Time compared with a deep network of today* has the times.\n"
    )


def _foreign_table(foreign: JsonMapping) -> str:
    if not foreign:
        return "*No pictures of other cameras were named.*\n\n"
    rows = [["pictures", "detector", f"signs of the 43 classes found at {RATE} false detections a picture"]]
    for folder, by_name in foreign.items():
        for name in (ACF, YOLO):
            c = by_name[name]
            rows.append([f"{folder} ({c['pictures']})", name, f"{c['43_at_rate']} of {c['43']}"])
    return f"Pictures of other cameras, signs from 20 px:\n\n{table(rows)}\n"


def _group_table(group: str, by_name: JsonMapping) -> str:
    rows = [[
        f"clips {group}", "HOTA", "IDF1", "MOTA", "signs found", "false tracks", "ids per sign", "coverage",
        "mean Eq. 7", "uncovered as 1",
    ]]  # fmt: skip
    for name in (OURS, OURS_ON_YOLO, *sorted(set(by_name) - {OURS, OURS_ON_YOLO})):
        s = by_name[name]
        title = name if name in {OURS, OURS_ON_YOLO} else f"{YOLO} and {name}"
        rows.append([
            title, *(number(s[key], 3) for key in ("HOTA", "IDF1", "MOTA")),
            f"{s['signs_detected']} of {s['signs']}", str(s["false_tracks"]), number(s["ids_per_sign"], 2),
            f"{100 * (s['coverage'] or 0):.1f} %", number(s["mean_error"], 3), number(s["mean_error_overall"], 3),
        ])  # fmt: skip
    return f"{table(rows)}\n"


def _plot(result: Result, path: Path) -> None:
    draw_precision_recall(path, result.figures["scenes"], {YOLO: "--", ACF: "-"})


EXPERIMENT = Experiment(
    "yolo",
    "YOLO11n trained on the same scenes, with trackers of today",
    "How does the engine compare with what people would pick today, a YOLO network trained on a GPU on the same scenes "
    "and a tracker behind it?",
    _run,
    _report,
    _plot,
    optional=("foreign",),
)
