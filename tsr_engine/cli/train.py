"""`tsr train`: models from the GTSDB and GTSRB folders, or refined by exports of corrections."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tsr_engine.cli.common import JsonOption, out_console, print_json, say
from tsr_engine.errors import InputError, UsageError
from tsr_engine.extras import require_extra
from tsr_engine.json_shapes import JsonObject
from tsr_engine.plural import plural

if TYPE_CHECKING:
    from tsr_engine.training.report import Report

TRAINED_PARTS = ("detector", "prior", "classifier", "online", "memory")
"""Components trained on public data."""
REFINED_PARTS = ("detector", "prior", "lambda", "classifier", "online")
"""Parts that corrections refine."""

app = typer.Typer(
    help="Train models from annotated scenes (GTSDB) and crops (GTSRB), or refine an earlier version with exported "
    "corrections. The same seed and data give the same models.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

GtsdbOption = Annotated[
    Path | None,
    typer.Option("--gtsdb", metavar="DIR", help="Folder of GTSDB scenes with gt.txt; with --export: for figures."),
]
GtsrbOption = Annotated[
    Path | None,
    typer.Option(
        "--gtsrb", metavar="DIR", help="Folder of GTSRB class folders 00000 to 00042; with --export: for figures."
    ),
]
ScenesOption = Annotated[Path | None, typer.Option("--gtsdb", metavar="DIR", help="GTSDB scenes with gt.txt.")]
CropsOption = Annotated[Path | None, typer.Option("--gtsrb", metavar="DIR", help="GTSRB class folders 00000 to 00042.")]
SignsOption = Annotated[
    Path | None,
    typer.Option(
        "--signs", metavar="FILE", help="Annotations of other signs in the GTSDB scenes, which are then no background."
    ),
]
OutOption = Annotated[Path, typer.Option("--out", metavar="MODELS", help="Model folder; other components in it stay.")]
SeedOption = Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Seed of all random choices.")]
DeviceOption = Annotated[str, typer.Option("--device", metavar="cuda|cpu", help="Device of PyTorch.")]
ExportOption = Annotated[
    list[Path],
    typer.Option(
        "--export", metavar="EXPORT", help="Export of corrections, folder or ZIP; repeatable. Refines --from."
    ),
]
VideoOption = Annotated[
    list[Path],
    typer.Option("--video", metavar="FILE", help="Video of an export without pictures, found by its hash; repeatable."),
]
FromOption = Annotated[
    Path | None, typer.Option("--from", metavar="MODELS", help="Version that --export refines; unset: the shipped one.")
]


@app.command("detector")
def detector(
    out: OutOption, gtsdb: GtsdbOption = None, gtsrb: GtsrbOption = None, export: ExportOption = [],  # noqa: B006
    video: VideoOption = [], parent: FromOption = None, seed: SeedOption = 0, json: JsonOption = False,  # noqa: B006
    signs: SignsOption = None,
) -> None:  # fmt: skip
    """Train the ACF detector on scenes, and on crops if --gtsrb names them (long); or refine it.

    \b
    Examples:
      tsr train detector --gtsdb GTSDB --gtsrb GTSRB --out models
      tsr train detector --gtsdb GTSDB --gtsrb GTSRB --signs gtsdb_signs.json --out models
      tsr train detector --export corrections.zip --video drive.mp4 --out version2
    """
    _train(_Training(("detector",), out, seed, json, gtsdb, gtsrb, export, video, parent, signs))


@app.command("prior")
def prior(
    out: OutOption, gtsdb: GtsdbOption = None, gtsrb: GtsrbOption = None, export: ExportOption = [],  # noqa: B006
    video: VideoOption = [], parent: FromOption = None, seed: SeedOption = 0, json: JsonOption = False,  # noqa: B006
) -> None:  # fmt: skip
    """Estimate the spatial prior and its weight (equation 8) for the detector in --out; or add corrected boxes to it.

    \b
    Example:
      tsr train prior --gtsdb GTSDB --out models
    """
    _train(_Training(("prior",), out, seed, json, gtsdb, gtsrb, export, video, parent))


@app.command("lambda")
def weight(
    out: OutOption, gtsdb: GtsdbOption = None, gtsrb: GtsrbOption = None, export: ExportOption = [],  # noqa: B006
    video: VideoOption = [], parent: FromOption = None, seed: SeedOption = 0, json: JsonOption = False,  # noqa: B006
) -> None:  # fmt: skip
    """Learn the prior's weight (equation 8) again from corrections; the table of the prior stays.

    \b
    Example:
      tsr train lambda --export corrections.zip --video drive.mp4 --out version2
    """
    if not export:
        raise UsageError("lambda alone is learned from corrections: name --export. `tsr train prior` learns both.")
    _train(_Training(("lambda",), out, seed, json, gtsdb, gtsrb, export, video, parent))


@app.command("classifier")
def classifier(
    out: OutOption, gtsdb: GtsdbOption = None, gtsrb: GtsrbOption = None, export: ExportOption = [],  # noqa: B006
    video: VideoOption = [], parent: FromOption = None, seed: SeedOption = 0, json: JsonOption = False,  # noqa: B006
) -> None:  # fmt: skip
    """Train the classifier on crops; or refine it.

    \b
    Example:
      tsr train classifier --gtsrb GTSRB --out models
    """
    _train(_Training(("classifier",), out, seed, json, gtsdb, gtsrb, export, video, parent))


@app.command("network")
def network(
    out: OutOption, gtsrb: CropsOption = None, device: DeviceOption = "cuda", seed: SeedOption = 0,
    json: JsonOption = False,
) -> None:  # fmt: skip
    """Train the network that reads beside the classifier, with PyTorch (minutes on a GPU, days without).

    \b
    Examples:
      tsr train network --gtsrb GTSRB --out models
      tsr train network --gtsrb GTSRB --out models --device cpu
    """
    require_extra("torch")
    _train(_Training(("network",), out, seed, json, gtsrb=gtsrb, device=device))


@app.command("online")
def online(
    out: OutOption, gtsdb: GtsdbOption = None, gtsrb: GtsrbOption = None, export: ExportOption = [],  # noqa: B006
    video: VideoOption = [], parent: FromOption = None, seed: SeedOption = 0, json: JsonOption = False,  # noqa: B006
) -> None:  # fmt: skip
    """Draw the initial samples of every track's online detector; or replace some by corrected ones.

    \b
    Example:
      tsr train online --gtsdb GTSDB --out models
    """
    _train(_Training(("online",), out, seed, json, gtsdb, gtsrb, export, video, parent))


@app.command("memory")
def memory(
    out: OutOption, gtsdb: ScenesOption = None, gtsrb: CropsOption = None, seed: SeedOption = 0,
    json: JsonOption = False, signs: SignsOption = None,
) -> None:  # fmt: skip
    """Draw the training samples that later refinements keep, for the detector and classifier in --out.

    \b
    Example:
      tsr train memory --gtsdb GTSDB --gtsrb GTSRB --out models
    """
    _train(_Training(("memory",), out, seed, json, gtsdb, gtsrb, signs=signs))


@app.command("other-shapes")
def other_shapes(
    out: OutOption, gtsdb: ScenesOption = None, signs: SignsOption = None, seed: SeedOption = 0,
    json: JsonOption = False,
) -> None:  # fmt: skip
    """Train the detector of signs outside the 43 classes, beside the detector in --out (long).

    \b
    Example:
      tsr train other-shapes --gtsdb GTSDB --signs gtsdb_signs.json --out models
    """
    if signs is None:
        raise UsageError("Training other-shapes needs --signs FILE, the annotations of other signs.")
    _train(_Training(("other_shapes",), out, seed, json, gtsdb, signs=signs))


@app.command("all")
def everything(
    out: OutOption, gtsdb: GtsdbOption = None, gtsrb: GtsrbOption = None, export: ExportOption = [],  # noqa: B006
    video: VideoOption = [], parent: FromOption = None, seed: SeedOption = 0, json: JsonOption = False,  # noqa: B006
    signs: SignsOption = None,
) -> None:  # fmt: skip
    """Train all components but network and other-shapes, one after the other; or refine an earlier version.

    \b
    Examples:
      tsr train all --gtsdb GTSDB --gtsrb GTSRB --out models --seed 0
      tsr train all --export corrections.zip --video drive.mp4 --from models --out version2
    """
    parts = REFINED_PARTS if export else TRAINED_PARTS
    _train(_Training(parts, out, seed, json, gtsdb, gtsrb, export, video, parent, signs))


@dataclass(frozen=True, slots=True)
class _Training:
    """What a command asks for: ``exports`` refine ``parent``; without, the data sets train from scratch."""

    parts: tuple[str, ...]
    out: Path
    seed: int
    as_json: bool
    gtsdb: Path | None = None
    gtsrb: Path | None = None
    exports: Sequence[Path] = ()
    videos: Sequence[Path] = ()
    parent: Path | None = None
    signs: Path | None = None
    device: str = "cpu"


def _train(asked: _Training) -> None:
    """Refine if there are exports, else train from scratch."""
    for folder, option in ((asked.gtsdb, "--gtsdb"), (asked.gtsrb, "--gtsrb"), (asked.parent, "--from")):
        if folder is not None and not folder.is_dir():
            raise InputError(f"There is no folder at {folder}, named by {option}. Unpack the data set there.")
    from tsr_engine.io.atomic import refuse_unwritable
    from tsr_engine.io.models import MANIFEST, read_manifest

    refuse_unwritable(asked.out)
    if (asked.out / MANIFEST).exists():
        read_manifest(asked.out)  # what cannot be added to is refused before hours of training, not after
    if asked.exports and asked.signs is not None:
        raise UsageError("--signs goes with training from scenes: --export takes no scenes. Leave one of them out.")
    if asked.exports:
        _refine(asked)
        return
    if asked.parent is not None or asked.videos:
        raise UsageError(
            "--from and --video go with --export: they refine a version. Name an export, or leave them out."
        )
    _train_from_scratch(asked)


def _train_from_scratch(asked: _Training) -> None:
    """Train, write and report each component."""
    parts, out, gtsdb, gtsrb = asked.parts, asked.out, asked.gtsdb, asked.gtsrb
    needs_scenes = bool({"detector", "prior", "online", "memory", "other_shapes"} & set(parts))
    needs_crops = bool({"classifier", "network", "memory"} & set(parts))
    for needed, folder, option in ((needs_scenes, gtsdb, "--gtsdb"), (needs_crops, gtsrb, "--gtsrb")):
        if needed and folder is None:
            shown = ", ".join(parts).replace("_", "-")
            raise UsageError(f"Training {shown} needs {option} DIR. Name the unpacked data folder.")
    from tsr_engine.cli.progress import progress_bar
    from tsr_engine.io.models import component_path, save_component
    from tsr_engine.training.public.network_classifier import train_network
    from tsr_engine.training.public.train_parts import train_component

    figures: JsonObject = {}
    for part in parts:
        with progress_bar(f"training {part}", "") as show:
            if part == "network" and gtsrb is not None:
                component = train_network(gtsrb, asked.seed, asked.device, _stage_progress(show))
            else:
                component = train_component(part, out, asked.seed, _stage_progress(show), gtsdb, gtsrb, asked.signs)
        digest = save_component(component, out)
        figures[component.name] = {"sha256": digest, "figures": dict(component.figures)}
    if asked.as_json:
        print_json({"models": str(out), "seed": asked.seed, "components": figures})
        return
    console = out_console()
    for part, found in figures.items():
        console.print(f"{part}: {component_path(part, out)}, sha256 {found['sha256'][:12]}", soft_wrap=True)
        for name, value in found["figures"].items():
            console.print(f"  {name}: {value}", soft_wrap=True)


def _refine(asked: _Training) -> None:
    """Refine a version and print its figures beside those of its parent."""
    out, parent = asked.out, asked.parent
    if out.exists() and parent is not None and out.resolve() == parent.resolve():
        raise UsageError("--out names the folder of --from. A version is never overwritten: name another folder.")
    from tsr_engine.io.models import MANIFEST

    if (out / MANIFEST).exists():
        raise UsageError(f"{out} holds a version already, which is never overwritten. Name another folder with --out.")
    from tsr_engine.cli.progress import progress_bar
    from tsr_engine.io.video_probe import video_sha256
    from tsr_engine.training.corrections.exports import open_export
    from tsr_engine.training.corrections.retrain import Recipe, retrain

    for video in asked.videos:
        if not video.is_file():
            raise InputError(f"There is no video at {video}, named by --video. Check the path.")
    by_hash = {video_sha256(video): video for video in asked.videos}
    wanted = set()

    def find(sha256: str, _: str) -> Path | None:
        wanted.add(sha256)
        return by_hash.get(sha256)

    with tempfile.TemporaryDirectory(prefix="tsr-train-") as name, progress_bar("refining", "") as show:
        work = Path(name)
        opened = [open_export(path, find, work) for path in asked.exports]
        for sha256, video in by_hash.items():
            if sha256 not in wanted:
                say(f"warning: no export is of {video}, named by --video: its bytes are others than those exported.")
        recipe = Recipe(parts=asked.parts, seed=asked.seed)
        report = retrain(opened, recipe, parent, out, work, _stage_progress(show), gtsdb=asked.gtsdb, gtsrb=asked.gtsrb)
    if asked.as_json:
        print_json({
            "models": str(out), "seed": asked.seed, "components": dict(report.models),
            "figures": dict(report.figures), "lineage": dict(report.lineage),
        })  # fmt: skip
        return
    _print_refined(out, report)


def _print_refined(out: Path, report: Report) -> None:
    from rich.table import Table

    console = out_console()
    used = report.lineage["used"]
    signs, frames = plural(used["signs"], "corrected sign"), plural(used["frames"], "frame")
    console.print(f"{out}: refined from {signs} in {frames}.", soft_wrap=True)
    for key in report.lineage.get("added_labels", []):
        console.print(f"{key}: a label that the earlier version lacks, now read.", soft_wrap=True)
    for note in report.lineage["notes"]:
        console.print(f"left out: {note}", soft_wrap=True)
    table = Table("on", "figure", "earlier", "new", box=None, pad_edge=False, header_style="bold")
    for where, found in report.figures.items():
        if where != "worse":
            for figure, value in found["new"].items():
                table.add_row(where, figure, str(found["parent"].get(figure, "")), str(value))
    console.print(table)
    if "corrections" not in report.figures:
        console.print("There were too few corrected signs to hold any out for figures.")
    for sentence in report.figures["worse"]:
        console.print(f"worse: {sentence}", soft_wrap=True)


def _stage_progress(show: Callable[[int, int, str], None]) -> Callable[[str, int, int], None]:
    return lambda stage, done, total: show(done, total, stage)
