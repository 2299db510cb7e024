"""`tsr eval`: how well the engine does on annotated data."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsr_engine.cli.common import (
    FormerNetworkOption,
    JsonOption,
    ModelsOption,
    ParameterCommand,
    PresetOption,
    ReaderOption,
    SetOption,
    make_params,
    make_reader,
    out_console,
    print_json,
)
from tsr_engine.cli.eval_data import (
    check_output_folder,
    held_out_scenes,
    select_crops,
    track_without_files,
    write_figures,
)
from tsr_engine.cli.eval_videos import find_annotated_videos, find_ground_truth, find_results, keep_readable
from tsr_engine.cli.tracking_table import print_summaries
from tsr_engine.errors import InputError, UsageError
from tsr_engine.json_shapes import JsonObject
from tsr_engine.plural import plural
from tsr_engine.runs.report_json import class_name

app = typer.Typer(
    help="Measure detection, classification, fusion or tracking on annotated data.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

OutOption = Annotated[
    Path | None, typer.Option("--out", metavar="DIR", help="Folder for figures as JSON and plots as PNG.")
]
HeldOutOption = Annotated[
    float | None,
    typer.Option("--held-out", metavar="SHARE", help="Only this share of the tracks, drawn by --seed as in training."),
]
SeedOption = Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Seed of the split.")]


@app.command("tracking", cls=ParameterCommand)
def tracking(
    videos: Annotated[list[Path], typer.Argument(metavar="VIDEO_OR_FOLDER...", help="Annotated videos.")],
    truth: Annotated[
        Path | None,
        typer.Option("--truth", metavar="DIR", help="Folder of <video>.csv; unset: beside the video, or in gt/ there."),
    ] = None,
    results: Annotated[
        Path | None,
        typer.Option("--results", metavar="DIR", help="Score <video>.csv of this folder instead of tracking."),
    ] = None,
    kf_alone: Annotated[
        bool, typer.Option("--kf-alone", help="Also track with the Kalman filter alone, for comparison (Fig. 11).")
    ] = False,
    min_width: Annotated[float, typer.Option("--min-width", help="Narrowest sign that counts, px.")] = 20.0,
    preset: PresetOption = "default",
    settings: SetOption = [],  # noqa: B006 - typer copies it
    models: ModelsOption = None,
    out: OutOption = None,
    json: JsonOption = False,
) -> None:
    """Score tracking: localisation error (equation 7), coverage, identities, Tables I and II by physical sign.

    Ground truth is a CSV with the columns frame,track_id,x1,y1,x2,y2,class_id,visibility,ignore. Boxes of both sides
    are first cut at the picture's edge.

    \b
    Examples:
      tsr eval tracking clips/ --kf-alone --out report
      tsr eval tracking drive.mp4 --truth annotations --preset paper
    """
    params = make_params(preset, settings)
    if not 0 <= min_width < float("inf"):
        raise UsageError(f"--min-width expects px, 0 or more. Got {min_width}.")
    tracking_options = {"--kf-alone": kf_alone, "--preset": preset != "default", "--set": settings, "--models": models}
    if results is not None and (useless := [option for option, given in tracking_options.items() if given]):
        raise UsageError(f"{useless[0]} says how to track, and --results has it done. Leave one of them out.")
    from tsr_engine.evaluation.track_tables import read_clip_truth, read_results
    from tsr_engine.evaluation.tracking import evaluate_video, summarise

    check_output_folder(out)
    found = [(video, find_ground_truth(video, truth)) for video in find_annotated_videos(videos, truth)]
    pairs = keep_readable(found)
    annotations = [read_clip_truth(table, frames) for _, table, (frames, _, _) in pairs]
    runs = {preset: params}
    if kf_alone:
        runs["KF alone"] = params.with_settings([("use_online", False)])
    summaries: JsonObject = {}
    details: JsonObject = {}
    for name, chosen in runs.items():
        reports = []
        for (video, _, (frames, width, height)), annotated in zip(pairs, annotations, strict=True):
            if results is not None:
                rows = read_results(find_results(video, results))
            else:
                frames, rows = track_without_files(video, chosen, models, f"{name}: {video.name}")
            reports.append(evaluate_video(video.name, annotated, rows, frames, min_width, size=(width, height)))
        summaries[name] = summarise(reports)
        details[name] = [
            {"video": r.name, "signs": len(r.signs), "found": sum(bool(s.ids) for s in r.signs),
             "false_tracks": len(r.false_tracks)}
            for r in reports
        ]  # fmt: skip
    content = {name: summary.as_dict() | {"by_video": details[name]} for name, summary in summaries.items()}
    write_figures(out, "tracking.json", content)
    if out is not None:
        from tsr_engine.evaluation.plots import plot_errors

        plot_errors(summaries, out / "tracking_error.png")
    if json:
        print_json(content)
    else:
        print_summaries(summaries, details)
    if len(pairs) < len(found):
        raise InputError(
            f"{len(found) - len(pairs)} of {len(found)} videos could not be read; the figures are of the rest."
        )


@app.command("classification")
def classification(
    gtsrb: Annotated[
        Path, typer.Option("--gtsrb", metavar="DIR_OR_CSV", help="Class folders, or a table with ClassId.")
    ],
    held_out: HeldOutOption = None,
    seed: SeedOption = 0,
    models: ModelsOption = None,
    reader: ReaderOption = None,
    network: FormerNetworkOption = False,
    out: OutOption = None,
    json: JsonOption = False,
) -> None:
    """Score single crops: accuracy, recall by class, confusions.

    \b
    Examples:
      tsr eval classification --gtsrb Final_Test/Images/GT-final_test.csv --out report
      tsr eval classification --gtsrb Final_Training/Images --held-out 0.25
    """
    from tsr_engine.cli.progress import progress_bar
    from tsr_engine.evaluation.classification import evaluate_classification, predict_items
    from tsr_engine.labels.classes import class_names_of
    from tsr_engine.pipeline import load_reader

    reader_kind = make_reader(reader, network)
    check_output_folder(out)
    items = [item for item in select_crops(gtsrb, held_out, seed) if item.class_id is not None]
    if not items:
        raise InputError(f"{gtsrb} names no classes to compare with. Use class folders, or a table with ClassId.")
    classifier = load_reader(models, reader_kind)
    true, predicted = [], []
    with progress_bar("classifying", "crops") as show:
        for answer in predict_items(items, classifier):
            true.append(answer.item.class_id or 0)
            predicted.append(answer.class_id)
            show(len(true), len(items), "")
    names = class_names_of(classifier.labels or None)  # a retrained version may know more than the 43
    report = evaluate_classification(true, predicted, len(names))
    content = {
        "crops": report.pictures,
        "accuracy": report.accuracy,
        "recall_by_class": {str(c): recall for c, recall in report.per_class.items()},
        "confusions": [{"true": c.true, "predicted": c.predicted, "count": c.count} for c in report.confusions()],
    }
    write_figures(out, "classification.json", content)
    if out is not None:
        from tsr_engine.evaluation.plots import plot_confusion

        plot_confusion(report, out / "confusion.png")
    if json:
        print_json(content)
        return
    console = out_console()
    console.print(f"{report.accuracy:.4f} of {report.pictures} crops are right.")
    for confusion in report.confusions(8):
        shown, taken_for = class_name(confusion.true, names), class_name(confusion.predicted, names)
        console.print(f"  {confusion.count} times '{shown}' was taken for '{taken_for}'", soft_wrap=True)


@app.command("fusion", cls=ParameterCommand)
def fusion(
    gtsrb: Annotated[Path, typer.Option("--gtsrb", metavar="DIR", help="Class folders with tracks.")],
    held_out: HeldOutOption = None,
    seed: SeedOption = 0,
    settings: SetOption = [],  # noqa: B006 - typer copies it
    models: ModelsOption = None,
    out: OutOption = None,
    json: JsonOption = False,
) -> None:
    """Score fused tracks: share of right ones by number of frames and weighting (figure 13).

    \b
    Example:
      tsr eval fusion --gtsrb Final_Training/Images --held-out 0.25 --out report
    """
    params = make_params("default", settings)
    from tsr_engine.cli.progress import progress_bar
    from tsr_engine.evaluation.fusion import evaluate_fusion, track_votes
    from tsr_engine.pipeline import load_reader

    check_output_folder(out)
    crops = select_crops(gtsrb, held_out, seed)
    classifier = load_reader(models, params.pipeline.reader)
    with progress_bar("classifying", "tracks") as show:
        votes = track_votes(crops, classifier, lambda done, total: show(done, total, ""))
    report = evaluate_fusion(votes, params.fusion)
    content = report.as_dict()
    write_figures(out, "fusion.json", content)
    if out is not None:
        from tsr_engine.evaluation.plots import plot_fusion

        plot_fusion(report, out / "fusion.png")
    if json:
        print_json(content)
        return
    from rich.table import Table

    table = Table("frames", *report.rates, box=None, pad_edge=False, header_style="bold")
    for i, frames in enumerate(report.frames):
        if frames in (1, 2, 3, 5, 8, 12, 16, 20, 25, report.frames[-1]):
            table.add_row(str(frames), *(f"{rates[i]:.4f}" for rates in report.rates.values()))
    console = out_console()
    console.print(f"{plural(report.tracks, 'track')}; {report.single:.4f} of their single crops are right.")
    console.print(table)


@app.command("detection", cls=ParameterCommand)
def detection(
    gtsdb: Annotated[Path, typer.Option("--gtsdb", metavar="DIR", help="Scenes with gt.txt.")],
    held_out: Annotated[
        bool, typer.Option("--held-out", help="Only the scenes that training reported on, by the model's own seed.")
    ] = False,
    preset: PresetOption = "default",
    settings: SetOption = [],  # noqa: B006 - typer copies it
    models: ModelsOption = None,
    out: OutOption = None,
    json: JsonOption = False,
) -> None:
    """Score detections in still scenes: AP at IoU 0.5, recall by false positives a picture, with and without prior.

    All 43 classes count as one.

    \b
    Example:
      tsr eval detection --gtsdb GTSDB --held-out --out report
    """
    params = make_params(preset, settings)
    from tsr_engine.cli.progress import progress_bar
    from tsr_engine.evaluation.detection import score_detections
    from tsr_engine.io.gtsdb import read_gtsdb
    from tsr_engine.io.pictures import read_picture
    from tsr_engine.pipeline import load_detector

    check_output_folder(out)
    scenes = held_out_scenes(read_gtsdb(gtsdb), models) if held_out else read_gtsdb(gtsdb)
    if not any(len(scene.boxes) for scene in scenes):
        raise InputError(f"{gtsdb} has no scene with signs to score. Name annotated scenes.")
    detector = load_detector(params, models)
    found = []
    with progress_bar("detecting", "scenes") as show:
        for done, scene in enumerate(scenes, 1):
            found.append((detector.detect(read_picture(scene.path)), scene.boxes))
            show(done, len(scenes), "")
    curves = {
        "with prior": score_detections([(d.boxes, d.scores, truth) for d, truth in found]),
        "raw score": score_detections([(d.boxes, d.raw_scores, truth) for d, truth in found]),
    }
    content = {
        name: {
            "pictures": curve.pictures,
            "signs": curve.signs,
            "average_precision": curve.average_precision,
            "recall_at": {str(rate): curve.recall_at(rate) for rate in (0.03, 0.1, 1.0)},
        }
        for name, curve in curves.items()
    }
    write_figures(out, "detection.json", content)
    if out is not None:
        from tsr_engine.evaluation.plots import plot_curves

        plot_curves(curves, out / "precision_recall.png")
    if json:
        print_json(content)
        return
    console = out_console()
    for name, curve in curves.items():
        recalls = ", ".join(f"{curve.recall_at(rate):.3f} at {rate:g}" for rate in (0.03, 0.1, 1.0))
        console.print(
            f"{name}: AP {curve.average_precision:.4f} over {curve.signs} signs in {curve.pictures} scenes; recall "
            f"{recalls} false positives a scene",
            soft_wrap=True,
        )
