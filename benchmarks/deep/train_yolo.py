"""Train YOLO11n on the scenes that the ACF detector of the report was trained on, with Ultralytics' own recipe.

    python -m benchmarks.deep.train_yolo FOLDER --gtsdb GTSDB --minutes 9 --device 0

The scenes are written to FOLDER/scenes once; without --gtsdb those of an earlier call are used, so a machine with a
GPU needs only that folder and `ultralytics`. Writes FOLDER/yolo11n_signs.pt, the same network as .onnx for inputs of
1376x800 px, which covers a scene, and .json with the cost of the training. Needs `ultralytics`, `torch` and `onnx`.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import time
from pathlib import Path
from typing import Any

from benchmarks.deep.yolo import ARCHITECTURE

NAME = "yolo11n_signs"
SIZE = (1376, 800)
"""Width and height of the network's input, px."""
BATCH = 16
SEED = 0


def write_scenes(gtsdb: Path, folder: Path) -> None:
    """Write pictures, labels and the description of the data in the form that Ultralytics reads.

    The detector's scenes for training and for calibration are the training scenes, because nothing is calibrated here.
    All signs are one class, as in the report.
    """
    from tsr_engine.io.gtsdb import read_gtsdb
    from tsr_engine.io.pictures import read_picture
    from tsr_engine.training.public.detector_components import split_scenes

    train, calibrate, _ = split_scenes(read_gtsdb(gtsdb), SEED)
    shutil.rmtree(folder, ignore_errors=True)
    pictures, labels = folder / "images", folder / "labels"
    pictures.mkdir(parents=True)
    labels.mkdir()
    for scene in (*train, *calibrate):
        shutil.copyfile(scene.path, pictures / scene.path.name)
        height, width = read_picture(scene.path).shape[:2]
        rows = [
            f"0 {(x0 + x1) / 2 / width:.7f} {(y0 + y1) / 2 / height:.7f} "
            f"{(x1 - x0) / width:.7f} {(y1 - y0) / height:.7f}\n"
            for x0, y0, x1, y1 in scene.boxes
        ]
        (labels / f"{scene.path.stem}.txt").write_text("".join(rows), encoding="utf-8")
    (folder / "counts.json").write_text(
        json.dumps({
            "scenes": len(train) + len(calibrate),
            "signs": sum(len(scene.boxes) for scene in (*train, *calibrate)),
            "seed": SEED,
        }) + "\n",
        encoding="utf-8",
    )  # fmt: skip


def train(folder: Path, minutes: float, device: str) -> None:
    """Train from random weights for some minutes, and write the last weights, averaged as Ultralytics does."""
    os.environ.setdefault("YOLO_OFFLINE", "true")
    os.environ.setdefault("YOLO_AUTOINSTALL", "false")
    os.environ.setdefault("YOLO_CONFIG_DIR", str(folder))
    import torch
    import ultralytics

    scenes = folder / "scenes"
    description = folder / "signs.yaml"
    description.write_text(
        f"path: {json.dumps(str(scenes.resolve()))}\ntrain: images\nval: images\nnames:\n  0: sign\n", encoding="utf-8"
    )
    yolo: Any = ultralytics.YOLO(ARCHITECTURE, verbose=False)  # Any: its trainer is typed as optional
    began = time.monotonic()
    yolo.train(
        data=str(description), imgsz=SIZE[0], batch=BATCH, time=minutes / 60, device=device, seed=SEED,
        nbs=BATCH, cache="ram", workers=os.cpu_count() or 1, pretrained=False, val=False, plots=False,
        deterministic=False, project=str(folder.resolve()), name="run", exist_ok=True,
    )  # fmt: skip
    spent = time.monotonic() - began
    shutil.copyfile(folder / "run" / "weights" / "last.pt", folder / f"{NAME}.pt")
    about = {
        **json.loads((scenes / "counts.json").read_text(encoding="utf-8")),
        "epochs": int(yolo.trainer.epoch) + 1,
        "minutes": round(spent / 60, 1),
        "parameters": sum(p.numel() for p in yolo.trainer.model.parameters()),
        "device": torch.cuda.get_device_name() if device != "cpu" else "CPU",
        "torch": torch.__version__,
        "ultralytics": ultralytics.__version__,
    }
    (folder / f"{NAME}.json").write_text(json.dumps(about, indent=1, sort_keys=True) + "\n", encoding="utf-8")


def export(folder: Path) -> None:
    """Write the trained network as ONNX, without its suppression of overlapping boxes."""
    import ultralytics

    yolo: Any = ultralytics.YOLO(folder / f"{NAME}.pt", verbose=False)  # Any: see train
    yolo.export(format="onnx", imgsz=(SIZE[1], SIZE[0]), simplify=False, device="cpu")


def main() -> None:
    """Read the command line, write the scenes, train and export."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--gtsdb", type=Path, help="folder of the scenes; unset: FOLDER/scenes was written before")
    parser.add_argument("--minutes", type=float, default=9.0, help="time of the training")
    parser.add_argument("--device", default="0", help="a GPU's number, or cpu")
    parser.add_argument("--only", choices=("scenes", "train", "export"), help="one step")
    args = parser.parse_args()
    steps = (args.only,) if args.only else ("scenes", "train", "export")
    scenes = args.folder / "scenes"
    if args.gtsdb is None and args.only != "export" and not (scenes / "counts.json").is_file():
        parser.error(f"there are no scenes in {scenes} yet; name --gtsdb")
    if "scenes" in steps and args.gtsdb is not None:
        write_scenes(args.gtsdb, scenes)
    if "train" in steps:
        train(args.folder, args.minutes, args.device)
    if "export" in steps:
        export(args.folder)


if __name__ == "__main__":
    main()
