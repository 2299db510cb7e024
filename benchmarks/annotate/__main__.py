"""Makes sheets for the annotator, and annotations from the answers.

python -m benchmarks.annotate cutouts --gtsdb GTSDB --out FOLDER    numbered cut-outs of candidates
python -m benchmarks.annotate scenes --gtsdb GTSDB --out FOLDER     whole scenes, the signs of gt.txt framed
python -m benchmarks.annotate again --gtsdb GTSDB --out FOLDER      signs and controls, shuffled, without names
python -m benchmarks.annotate compile --gtsdb GTSDB                 writes benchmarks/data/gtsdb_signs.json
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from benchmarks.annotate.answers import read_controls, read_places
from benchmarks.annotate.candidates import candidates_of, sensitive_detector
from benchmarks.annotate.sheets import cut, scene_rows
from benchmarks.annotate.signs import SIGNS, compile_signs, save
from benchmarks.reporting.contact_sheet import grid
from tsr_engine.io.gtsdb import Scene, read_gtsdb
from tsr_engine.io.pictures import read_picture
from tsr_engine.records import Picture

SEED = 39
CONTROLS = 70
Cell = tuple[str, Picture]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.annotate", description=__doc__.split("\n\n")[0])
    parser.add_argument("what", choices=("cutouts", "scenes", "again", "compile"))
    parser.add_argument("--gtsdb", type=Path, required=True, help="the 600 training scenes with gt.txt")
    parser.add_argument("--out", type=Path, default=Path("out/annotate"), help="folder for the sheets")
    args = parser.parse_args(argv)
    scenes = read_gtsdb(args.gtsdb)
    if args.what == "compile":
        annotations = compile_signs(read_places(), read_controls(), scenes)
        save(annotations)
        print(f"{SIGNS}: {len(annotations.signs)} signs, {annotations.figures}")
        return 0
    args.out.mkdir(parents=True, exist_ok=True)
    if args.what == "scenes":
        for first in range(0, len(scenes), 3):
            rows = scene_rows([(s.path.stem, read_picture(s.path), s.boxes) for s in scenes[first : first + 3]])
            _write(args.out, args.what, first // 3, rows)
        return 0
    cells, side, columns = (_cutouts(scenes), 82, 15) if args.what == "cutouts" else (_again(scenes), 104, 12)
    pages = iter(lambda: list(islice(cells, columns * 10)), [])
    for number, page in enumerate(pages):
        _write(args.out, args.what, number, grid(page, side, columns))
    return 0


def _cutouts(scenes: Sequence[Scene]) -> Iterator[Cell]:
    detector = sensitive_detector()
    number = 0
    for scene in scenes:
        picture = read_picture(scene.path)
        for box in candidates_of(picture, scene.boxes, detector):
            yield str(number), cut(picture, box, 82, 0.35)
            number += 1


def _again(scenes: Sequence[Scene]) -> Iterator[Cell]:
    """Signs of the close look and a sample of ``gt.txt``, shuffled; the number is the index in the shuffled list."""
    by_name = {scene.path.stem: scene for scene in scenes}
    chance = np.random.default_rng(SEED)
    signs = [(place.scene, np.array(place.box)) for place in read_places() if place.close not in ("none", "board")]
    known = [(scene.path.stem, box) for scene in scenes for box in scene.boxes]
    items = signs + [known[i] for i in chance.choice(len(known), CONTROLS, replace=False)]
    for number, place in enumerate(chance.permutation(len(items))):
        name, box = items[place]
        yield str(number), cut(read_picture(by_name[name].path), box, 104, 0.22)


def _write(folder: Path, name: str, number: int, page: object) -> None:
    cv2.imwrite(str(folder / f"{name}_{number:03d}.jpg"), page, [cv2.IMWRITE_JPEG_QUALITY, 90])


if __name__ == "__main__":
    raise SystemExit(main())
