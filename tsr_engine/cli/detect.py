"""`tsr detect`: signs in still pictures."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

import json as json_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tsr_engine.cli.common import (
    JsonOption,
    ModelsOption,
    OnnxLayoutOption,
    OnnxOption,
    OnnxSizeOption,
    PresetOption,
    SetOption,
    make_network,
    make_params,
    print_json,
    say,
)
from tsr_engine.errors import InputError
from tsr_engine.json_shapes import JsonObject
from tsr_engine.plural import plural

if TYPE_CHECKING:
    from tsr_engine.detection.other_shapes import OtherShapes
    from tsr_engine.pipeline import Components
    from tsr_engine.records import Detections, Picture


def detect(
    sources: Annotated[list[Path], typer.Argument(metavar="IMAGE_OR_FOLDER...", help="Pictures, folders of pictures.")],
    jsonl: Annotated[Path, typer.Option("--jsonl", metavar="OUT", help="Write one line for each picture.")],
    preset: PresetOption = "default",
    settings: SetOption = [],  # noqa: B006 - typer copies it
    models: ModelsOption = None,
    onnx: OnnxOption = None,
    onnx_size: OnnxSizeOption = None,
    onnx_layout: OnnxLayoutOption = None,
    other_shapes: Annotated[
        bool,
        typer.Option("--other-shapes", help="Also find signs that the classes lack: parking, one-way, no stopping."),
    ] = False,
    json: JsonOption = False,
) -> None:
    """Detect and classify the signs in pictures.

    Each line of the output is {"image": name, "detections": [{"x1", "y1", "x2", "y2", "score", "raw_score",
    "class_id", "class_prob"}]}, best detection first, in pixel edges. The scores are those with and without the
    spatial prior. Detections of --other-shapes have class_id -1 and class_prob null.
    Unreadable pictures are named on stderr; the others are processed and the exit code is 3. After Ctrl-C the finished
    lines are kept.

    \b
    Examples:
      tsr detect photo.jpg --jsonl found.jsonl
      tsr detect scenes/ --jsonl found.jsonl --set min_width=24
      tsr detect scenes/ --jsonl found.jsonl --other-shapes
      tsr detect scenes/ --jsonl found.jsonl --onnx signs.onnx --onnx-size 640x640
    """
    params = make_params(preset, settings)
    network = make_network(onnx, onnx_size, onnx_layout)
    from tsr_engine.cli.interrupt import leave_interrupted, stop_on_interrupt
    from tsr_engine.cli.progress import progress_bar
    from tsr_engine.io.atomic import atomic_text, refuse_inputs
    from tsr_engine.io.pictures import find_pictures, read_picture
    from tsr_engine.pipeline import load_components, load_other_shapes

    paths = list(find_pictures(sources))
    refuse_inputs([jsonl], paths)
    components = load_components(params, models, network)
    others = load_other_shapes(params, models) if other_shapes else None
    unreadable = found = done = 0
    with stop_on_interrupt() as stopped, atomic_text(jsonl) as out, progress_bar("detecting", "pictures") as show:
        for done, path in enumerate(paths, 1):
            try:
                picture = read_picture(path)
            except InputError as error:
                say(str(error))
                unreadable += 1
            else:
                rows = detections_of(components, picture, others)
                found += len(rows)
                out.write(json_module.dumps({"image": path.name, "detections": rows}, allow_nan=False) + "\n")
            show(done, len(paths), "")
            if stopped():
                break
    read = done - unreadable
    interrupted = done < len(paths)
    if json:
        counts = {"pictures": read, "unreadable": unreadable, "detections": found}
        print_json({**counts, "interrupted": interrupted, "jsonl": str(jsonl)})
    else:
        typer.echo(f"{plural(found, 'detection')} in {plural(read, 'picture')}: {jsonl}")
    output_state = f"the others are in {jsonl}" if read else f"{jsonl} has no line"
    unreadable_message = f"{unreadable} of {done} pictures could not be read; {output_state}."
    if interrupted:
        leave_interrupted(
            f"{done} of {len(paths)} pictures are done. {unreadable_message if unreadable else f'See {jsonl}.'}"
        )
    if unreadable:
        raise InputError(unreadable_message)


def detections_of(components: Components, picture: Picture, others: OtherShapes | None = None) -> list[JsonObject]:
    """The detections of one picture with their classes, as JSON values; ``others`` finds signs without a class."""
    from tsr_engine.recognition.crops import cut

    detections = components.detector.detect(picture)
    rows = []
    if len(detections):
        classifier = components.parts.classifier
        probabilities = classifier.probabilities([cut(picture, box, classifier.margin) for box in detections.boxes])
        for row, each in zip(_places(detections), probabilities, strict=True):
            best = int(each.argmax())
            rows.append(row | {"class_id": best, "class_prob": round(float(each[best]), 5)})
    if others is not None:
        found = others.detect(picture, detections)
        rows += [row | {"class_id": -1, "class_prob": None} for row in _places(found)]
        rows.sort(key=lambda row: -row["score"])
    return rows


def _places(detections: Detections) -> list[JsonObject]:
    """Boxes and scores of detections."""
    rows = []
    for box, score, raw in zip(detections.boxes, detections.scores, detections.raw_scores, strict=True):
        edges = dict(zip(("x1", "y1", "x2", "y2"), (round(float(v), 2) for v in box), strict=True))
        rows.append(edges | {"score": round(float(score), 5), "raw_score": round(float(raw), 5)})
    return rows
