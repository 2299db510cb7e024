"""`tsr train`: models from the GTSDB and GTSRB folders."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tsr_engine.cli.common import JsonOption, out_console, print_json
from tsr_engine.errors import InputError, UsageError

if TYPE_CHECKING:
    from tsr_engine.io.models import Component

__all__ = ["PARTS", "app"]

PARTS = ("detector", "prior", "classifier", "online")

app = typer.Typer(
    help="Train models from annotated scenes (GTSDB) and crops (GTSRB); the same seed and data give the same models.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

GtsdbOption = Annotated[Path | None, typer.Option("--gtsdb", metavar="DIR", help="Folder of GTSDB scenes with gt.txt.")]
GtsrbOption = Annotated[
    Path | None, typer.Option("--gtsrb", metavar="DIR", help="Folder of GTSRB class folders 00000 to 00042.")
]
OutOption = Annotated[Path, typer.Option("--out", metavar="MODELS", help="Model folder; other components in it stay.")]
SeedOption = Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Seed of everything random.")]

Report = Callable[[str, int, int], None]


@app.command("detector")
def detector(
    out: OutOption, gtsdb: GtsdbOption = None, gtsrb: GtsrbOption = None, seed: SeedOption = 0, json: JsonOption = False
) -> None:
    """Train the ACF detector on scenes, and on crops as further signs if --gtsrb names them (long).

    \b
    Example:
      tsr train detector --gtsdb GTSDB --gtsrb GTSRB --out models
    """
    _train(("detector",), gtsdb, gtsrb, out, seed, json)


@app.command("prior")
def prior(
    out: OutOption, gtsdb: GtsdbOption = None, gtsrb: GtsrbOption = None, seed: SeedOption = 0, json: JsonOption = False
) -> None:
    """Estimate the spatial prior and its weight (Eq. 8) for the detector in --out.

    \b
    Example:
      tsr train prior --gtsdb GTSDB --out models
    """
    _train(("prior",), gtsdb, gtsrb, out, seed, json)


@app.command("classifier")
def classifier(
    out: OutOption, gtsdb: GtsdbOption = None, gtsrb: GtsrbOption = None, seed: SeedOption = 0, json: JsonOption = False
) -> None:
    """Train the classifier on crops.

    \b
    Example:
      tsr train classifier --gtsrb GTSRB --out models
    """
    _train(("classifier",), gtsdb, gtsrb, out, seed, json)


@app.command("online")
def online(
    out: OutOption, gtsdb: GtsdbOption = None, gtsrb: GtsrbOption = None, seed: SeedOption = 0, json: JsonOption = False
) -> None:
    """Draw the samples that the online detector of every track starts from.

    \b
    Example:
      tsr train online --gtsdb GTSDB --out models
    """
    _train(("online",), gtsdb, gtsrb, out, seed, json)


@app.command("all")
def everything(
    out: OutOption, gtsdb: GtsdbOption = None, gtsrb: GtsrbOption = None, seed: SeedOption = 0, json: JsonOption = False
) -> None:
    """Train all components, one after the other.

    \b
    Example:
      tsr train all --gtsdb GTSDB --gtsrb GTSRB --out models --seed 0
    """
    _train(PARTS, gtsdb, gtsrb, out, seed, json)


def _train(parts: tuple[str, ...], gtsdb: Path | None, gtsrb: Path | None, out: Path, seed: int, as_json: bool) -> None:
    """Train, write and report one part after the other."""
    scenes, crops = _folders(parts, gtsdb, gtsrb)
    from tsr_engine.cli.progress import progress_bar
    from tsr_engine.io.models import save_component

    figures: dict[str, Any] = {}
    for part in parts:
        with progress_bar(f"training {part}", "") as show:
            component = _component(part, scenes, crops, out, seed, lambda stage, n, total: show(n, total, stage))
        digest = save_component(component, out)
        figures[part] = {"sha256": digest, "figures": dict(component.figures)}
    if as_json:
        print_json({"models": str(out), "seed": seed, "components": figures})
        return
    console = out_console()
    for part, found in figures.items():
        console.print(f"{part}: {out / part}.npz, sha256 {found['sha256'][:12]}", soft_wrap=True)
        for name, value in found["figures"].items():
            console.print(f"  {name}: {value}", soft_wrap=True)


def _folders(parts: tuple[str, ...], gtsdb: Path | None, gtsrb: Path | None) -> tuple[Path, Path | None]:
    """The data folders, checked before any long work.

    Raises:
        UsageError: one that a part needs was not named.
        InputError: one that was named is not there.
    """
    needs_scenes = bool({"detector", "prior", "online"} & set(parts))
    for needed, folder, option in ((needs_scenes, gtsdb, "--gtsdb"), ("classifier" in parts, gtsrb, "--gtsrb")):
        if needed and folder is None:
            raise UsageError(f"Training {', '.join(parts)} needs {option} DIR. Name the unpacked data folder.")
        if folder is not None and not folder.is_dir():
            raise InputError(f"There is no folder at {folder}, named by {option}. Unpack the data set there.")
    return gtsdb or Path(), gtsrb


def _component(part: str, scenes: Path, crops: Path | None, out: Path, seed: int, report: Report) -> Component:
    """Train one part."""
    if part == "classifier":
        from tsr_engine.training.classifier import train_classifier

        return train_classifier(crops or Path(), seed, progress=report)
    if part == "online":
        from tsr_engine.io.gtsdb import read_gtsdb
        from tsr_engine.training.online import train_online

        return train_online(read_gtsdb(scenes), seed)
    from tsr_engine.training.offline import train_detector, train_prior

    if part == "detector":
        return train_detector(scenes, crops, seed, report)
    from tsr_engine.io.models import load_component

    return train_prior(scenes, load_component("detector", out), seed, report)
