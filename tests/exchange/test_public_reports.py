"""Files from public bug reports: each gives the right frames, boxes, tracks and classes, or is refused.

A report is named by repository and number. Unless a case says otherwise, its boxes are ``box(frame)`` of class stop,
and the video is drive.mp4: 640x360 px, 100 frames, 30 frames a second.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from tests.exchange.reported_files import (
    TEN,
    YAML,
    box,
    boxes_xml,
    coco,
    cocovid,
    region,
    results,
    roboflow,
    rows,
    save_txt,
    task_xml,
    tasks,
    yolo,
)
from tests.exchange.small_datasets import CLASS_NAMES, GTSRB, make_video, target_of
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.load import read_dataset

STOP, NONE = CLASS_NAMES.index("stop"), -1
HASHES = ("0a1b2c3d4e5f60718293a4b5c6d7e8f3", "1a1b2c3d4e5f60718293a4b5c6d7ea51", "2a1b2c3d4e5f60718293a4b5c6d7eb07")
SPECIAL = "100% drive #1 ü.mp4"


@dataclass(frozen=True)
class Report:
    """What a report describes.

    Attributes:
        files: of the folder that is imported.
        frames: those in which boxes must be.
        tracks: how many tracks there must be; 0: not said.
        first: the first box; unset: ``box`` of the first frame.
        label: class of all boxes.
        reported: what the sentences must say, each.
        refused: what the refusal must say; then nothing else counts.
        video: name of the video.
        switches: of the import.
        labels: what a person says about names in the file.
    """

    files: Mapping[str, str]
    frames: Iterable[int] = TEN
    tracks: int = 0
    first: tuple[float, float, float, float] | None = None
    label: int = STOP
    reported: tuple[str, ...] = ()
    refused: str = ""
    video: str = "drive.mp4"
    switches: Mapping[str, str] = field(default_factory=dict)
    labels: Mapping[str, int] = field(default_factory=dict)


IMAGES = "".join(
    f'<image id="{n}" name="frame_{10 + n % 2:06d}" task_id="{1 + n // 2}" width="640" height="360">'
    '<box label="stop" occluded="0" xtl="100" ytl="10" xbr="130" ybr="40"/></image>'
    for n in range(4)
)
TURNED = coco({"frame_000010.jpg": 10}, note={"bbox": [100, 100, 160, 120], "attributes": {"rotation": 0.0}})
SINK = "x_min,y_min,x_max,y_max,class_id,confidence,tracker_id,class_name"
SINK_ROW = "{x1},{y1},{x2},{y2},0,0.9,7,stop,{f}"
HOLE = coco({"frame_000010.jpg": 10, "frame_000011.jpg": 11, "frame_000012.jpg": 12}).replace(
    "[112, 86.0, 40, 40.0]", "{}"
)
REPORTS = {
    "google-coral/tutorials#27: hash ends in digits": Report(roboflow(HASHES), (10, 11, 12)),
    "google-coral/tutorials#27: hash ends in a letter": Report(roboflow(f"{h[:-1]}a" for h in HASHES), (10, 11, 12)),
    "google-coral/tutorials#27: hash beyond the video": Report(roboflow(f"{h[:-3]}851" for h in HASHES), (10, 11, 12)),
    "google-coral/tutorials#27: hash in COCO": Report(
        {"a.json": coco({f"drive_mp4-{f:04d}_jpg.rf.{h}.jpg": f for f, h in enumerate(HASHES, 10)})}, (10, 11, 12)
    ),
    "ultralytics/ultralytics#9208: save_txt": Report(save_txt(range(6)), range(6), 1, reported=("from 1",)),
    "ultralytics/ultralytics#22256: save_txt to the end": Report(
        save_txt((97, 98, 99)), (97, 98, 99), reported=("from 1",)
    ),
    "open-mmlab/mmtracking#678: CocoVID": Report(
        {"cocovid.json": cocovid()}, (10, 10, 15, 15, 20, 20, 25, 25), 2, (100, 80, 140, 120)
    ),
    "cvat-ai/cvat#4502: CVAT project of videos": Report(
        {
            "annotations.xml": "<annotations><meta><project><id>1</id><tasks>"
            f"{task_xml(1, 'other.mp4', 40)}{task_xml(2, 'drive.mp4', 100)}</tasks></project></meta>"
            f'<track id="0" label="yield" task_id="1">{boxes_xml((3, 8))}</track>'
            f'<track id="1" label="stop" task_id="2">{boxes_xml(TEN, 40)}</track></annotations>'
        },
        tracks=1,
        reported=("other.mp4",),
    ),
    "cvat-ai/cvat#4993: COCO of two videos": Report(
        {"a.json": coco({f"{v}/frame_{f:06d}.jpg": f + 20 * (v == "other") for v in ("drive", "other") for f in TEN})},
        reported=("other",),
    ),
    "cvat-ai/cvat#3458: CVAT project of pictures": Report(
        {"annotations.xml": f"<annotations>{IMAGES}</annotations>"}, refused="task 1.*task 2"
    ),
    "HumanSignal/label-studio#5749: names that end alike": Report(
        tasks("other.mp4", "/data/upload/1/1a2b3c4d-rear-drive.mp4"), refused="rear-drive"
    ),
    "HumanSignal/label-studio#5749: one other task": Report(tasks("other.mp4"), reported=("other.mp4",)),
    "HumanSignal/label-studio#5749: one task that ends alike": Report(
        tasks("my-drive.mp4"), reported=("my-drive.mp4",)
    ),
    "HumanSignal/label-studio#1886: local storage": Report(tasks("other.mp4", "/data/local-files/?d=drive.mp4")),
    "HumanSignal/label-studio#878: sanitised upload": Report(
        tasks("other.mp4", "/data/upload/1/1a2b3c4d-100_drive_1_ü.mp4"), video=SPECIAL
    ),
    "HumanSignal/label-studio#2630: JSON-MIN": Report(
        {"min.json": json.dumps([{"video": "drive.mp4", "id": 1, "box": [region()["value"]], "annotator": 1}])},
        refused="Export as JSON, not JSON-MIN",
    ),
    "cvat-ai/cvat#4745: rotation in COCO": Report(
        {"a.json": TURNED.replace("0.0}", "90.0}")}, (10,), 1, (120, 80, 240, 240), reported=("Rotated",)
    ),
    "cheind/py-motmetrics#116: MOT ids from 0": Report(
        {
            "drive.txt": rows("{n},0,{x1},{y1},{w},{h},0.9,-1,-1,-1")
            + rows("{n},1,{x1},{y1},9,9,0.8,-1,-1,-1", (30, 31))
        },
        (*TEN, 30, 31),
        2,
        label=NONE,
    ),
    "VisDrone/VisDrone-Dataset#40: VisDrone": Report(
        {"drive.txt": rows("{n},4,{x1},{y1},{w},{h},1,4,0,1")},
        tracks=1,
        label=NONE,
        reported=("VisDrone",),
        labels={"car": NONE},
    ),
    "numpy/numpy#16176: numpy.savetxt": Report(
        {"drive.txt": rows("{n:.18e} 3e0 {x1:.18e} {y1:.18e} 4e1 4e1 9e-1 -1 -1 -1")}, tracks=1, label=NONE
    ),
    "mikel-brostrom/boxmot#1578: BoxMOT": Report(
        {"drive.txt": rows("{n},9,{x1},{y1},{w},{h},1,14,0.412")}, tracks=1, reported=("olumn 9",)
    ),
    "cvat-ai/cvat#3940: seqinfo.ini without a size": Report(
        {
            "gt/gt.txt": rows("{n},4,{x1},{y1},{w},{h},1,1,1"),
            "gt/labels.txt": "stop\nyield\n",
            "seqinfo.ini": "[Sequence]\nname=drive\nimDir=img1\nframeRate=30\nseqLength=100\nimExt=.jpg\n",
        },
        tracks=1,
    ),
    "roboflow/supervision#746: CSVSink": Report({"sv.csv": rows(SINK_ROW, header=f"{SINK},frame_number")}, tracks=1),
    "roboflow/supervision#746: CSVSink, frame_index": Report(
        {"sv.csv": rows(SINK_ROW, header=f"{SINK},frame_index")}, tracks=1
    ),
    "ultralytics/ultralytics#9208: to_json": Report({"res.json": json.dumps(results())}, tracks=1),
    "ultralytics/ultralytics#9208: a name beats a number": Report(
        {
            "res.csv": rows(
                "{f},stop,0,0.9,3,{x1},{y1},{x2},{y2}", header="frame,name,class,confidence,track_id,x1,y1,x2,y2"
            )
        },
        tracks=1,
    ),
    "voxel51/fiftyone#1374: FiftyOne without key frames": Report(
        {"drive.xml": f'<annotations><track id="1" label="stop">{boxes_xml(TEN, flags="")}</track></annotations>'},
        tracks=1,
    ),
    "own: a rounding below 0": Report(
        {"data.yaml": YAML, "labels/train/frame_000010.txt": "0 -0.0000001 0.5 0.0625 0.1\n"},
        (10,),
        first=(0, 162, 20, 198),
    ),
    "cocodataset/cocoapi#497: ids as 11.0": Report(
        {"a.json": coco({"frame_000010.jpg": 10}, note={"image_id": 1.0, "category_id": 1.0})}, (10,)
    ),
    "voxel51/fiftyone#1138: a box of no height": Report(
        {"a.json": HOLE.replace("{}", "[112, 86, 40, 0]")}, refused="bad_boxes"
    ),
    "voxel51/fiftyone#1138: a box of no height, left out": Report(
        {"a.json": HOLE.replace("{}", "[112, 86, 40, 0]")},
        (10, 11),
        switches={"bad_boxes": "skip"},
        reported=("1 box",),
    ),
    "CVHub520/X-AnyLabeling#397: no box at all, left out": Report(
        {"a.json": HOLE.replace("{}", "[]")}, (10, 11), switches={"bad_boxes": "skip"}
    ),
    "own: quoted keys in data.yaml": Report(
        {"data.yaml": '"names":\n  0: stop\n', "labels/train/frame_000010.txt": yolo(10)}, (10,)
    ),
}


@pytest.mark.parametrize("report", REPORTS.values(), ids=list(REPORTS))
def test_reported_files_are_read_correctly_or_refused(report: Report, tmp_path: Path) -> None:
    for file, content in report.files.items():
        path = tmp_path / "input" / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
    video = make_video(name=report.video, rate=Fraction(30), times=np.arange(100) / 30)
    target = target_of(Dataset(GTSRB, (video,)), switches=report.switches, label_map=report.labels)
    if report.refused:
        with pytest.raises(ImportFormatError, match=report.refused):
            read_dataset(tmp_path / "input", target)
        return
    back = read_dataset(tmp_path / "input", target)
    tracks = list(back.videos[0].tracks())
    frames = list(report.frames)
    assert sorted(frame for track in tracks for frame in track.frames.tolist()) == frames
    assert not report.tracks or len(tracks) == report.tracks
    assert {track.label for track in tracks} == {report.label}
    found = min((int(t.frames[0]), *t.boxes[0].tolist()) for t in tracks)
    assert found == pytest.approx((frames[0], *(report.first or box(frames[0]))), abs=0.01)
    reported = " ".join([*back.repaired, *(f"{left.what} {left.reason}" for left in back.skipped)])
    for words in report.reported:
        assert words in reported
