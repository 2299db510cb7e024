"""Exports YOLO11n's architecture with random weights as ONNX files of given input sizes, only to measure times.

    python -m benchmarks.deep.yolo FOLDER 736x576 1440x1152

Nothing is downloaded: `ultralytics` builds the network from its own description. A few pictures of noise set the batch
normalisations. Without that, activations would shrink from layer to layer to denormal numbers, which are slow. Needs
`ultralytics`, `torch` and `onnx`, in this interpreter or in that of `make oracles`.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

ARCHITECTURE = "yolo11n.yaml"


def export(folder: Path, sizes: list[tuple[int, int]]) -> None:
    """Write ``yolo11n_WxH.onnx`` for each (width, height), and ``yolo11n.json``, which describes them."""
    # Keep the package from searching for updates and writing settings.
    os.environ.setdefault("YOLO_OFFLINE", "true")
    os.environ.setdefault("YOLO_AUTOINSTALL", "false")
    folder = folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch, contextlib.chdir(scratch):  # it writes to the working folder
        os.environ.setdefault("YOLO_CONFIG_DIR", scratch)
        import torch
        import ultralytics

        torch.manual_seed(0)
        torch.set_num_threads(1)
        yolo: Any = ultralytics.YOLO(ARCHITECTURE, verbose=False)  # Any: its model is typed as a path too
        parameters = sum(p.numel() for p in yolo.model.parameters())
        yolo.model.train()
        with torch.no_grad():
            for layer in yolo.model.modules():
                if isinstance(layer, torch.nn.BatchNorm2d):
                    layer.momentum = None  # the mean over all pictures
            for _ in range(3):
                yolo.model(torch.rand(2, 3, 320, 320))
        yolo.model.eval()
        for width, height in sizes:
            made = yolo.export(format="onnx", imgsz=(height, width), simplify=False, device="cpu")
            shutil.move(made, folder / name_of((width, height)))
        about = {"ultralytics": ultralytics.__version__, "torch": torch.__version__, "parameters": parameters}
        (folder / "yolo11n.json").write_text(json.dumps(about, sort_keys=True) + "\n", encoding="utf-8")


def name_of(size: tuple[int, int]) -> str:
    """Name of the file for an input of (width, height) px."""
    return f"yolo11n_{size[0]}x{size[1]}.onnx"


def main() -> None:
    """Read the command line."""
    folder, *sizes = sys.argv[1:]
    export(Path(folder), [(int(w), int(h)) for w, h in (size.split("x") for size in sizes)])


if __name__ == "__main__":
    main()
