"""`tsr sample`: a procedural drive with exact truth, to try everything on."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsr_engine.cli.common import JsonOption, print_json, size_of
from tsr_engine.errors import UsageError


def sample(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder to write into.")] = Path("sample"),
    seconds: Annotated[float, typer.Option("--seconds", metavar="N", help="Length of the drive.")] = 12.0,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Each seed gives another drive.")] = 0,
    size: Annotated[str, typer.Option("--size", metavar="WxH", help="Size of the pictures, px.")] = "1280x720",
    fps: Annotated[int, typer.Option("--fps", metavar="N", help="Frames a second.")] = 25,
    scenario: Annotated[
        str | None, typer.Option("--scenario", metavar="NAME", help="Kind of drive; unset: by the seed.")
    ] = None,
    json: JsonOption = False,
) -> None:
    """Render a drive past drawn signs: a video, the exact boxes as CSV, and the facts as JSON.

    \b
    Examples:
      tsr sample --out sample --seconds 20 --seed 3
      tsr track sample/*.mp4 --video seen.mp4
    """
    width, height = size_of(size, "--size", "1280x720")
    from sample_videos.generate import generate
    from tsr_engine.cli.progress import progress_bar
    from tsr_engine.io.atomic import storage_error

    try:
        with progress_bar("rendering", "frames") as show:
            paths = generate(
                out, seconds, seed, (width, height), fps, lambda done, total: show(done, total, ""), scenario=scenario
            )
    except ValueError as error:
        raise UsageError(str(error)) from None
    except OSError as error:
        raise storage_error(out, error) from None
    if json:
        print_json({"video": str(paths.video), "truth": str(paths.truth), "facts": str(paths.facts)})
    else:
        typer.echo(f"{paths.video}\n{paths.truth}\n{paths.facts}")
