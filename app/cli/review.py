"""``tsr review``: the server and the browser from one command."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsr_engine.cli.common import existing
from tsr_engine.errors import InputError


def review(
    video: Annotated[Path | None, typer.Argument(help="A video to add and open.", show_default=False)] = None,
    home: Annotated[Path | None, typer.Option("--home", metavar="DIR", help="Data folder.", show_default=False)] = None,
    roots: Annotated[
        list[Path] | None,
        typer.Option("--root", metavar="DIR", help="Folder that videos may be added from; repeatable."),
    ] = None,
    host: Annotated[
        str | None, typer.Option("--host", help="Address to listen on; other than loopback it needs TSR_TOKEN.")
    ] = None,
    port: Annotated[int | None, typer.Option("--port", min=0, max=65535, help="Port; 0: any free one.")] = None,
    database: Annotated[
        str | None, typer.Option("--database", metavar="URL", help="Address of a database other than SQLite.")
    ] = None,
    workers: Annotated[int | None, typer.Option("--workers", min=0, max=64, help="Engine processes at once.")] = None,
    cores: Annotated[
        int | None,
        typer.Option(
            "--cores", min=1, max=64, metavar="N", help="Cores that one run uses; unset: up to 16, shared by the runs."
        ),
    ] = None,
    models: Annotated[Path | None, typer.Option("--models", metavar="DIR", help="Folder of model files.")] = None,
    sample: Annotated[
        bool | None, typer.Option("--sample/--no-sample", help="Put the bundled sample drives into the library.")
    ] = None,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page.")] = True,
) -> None:
    """Open the review tool in the browser: videos, runs of the engine, corrections.

    \b
    Examples:
      tsr review
      tsr review drive.mp4
      tsr review --root /data/drives --port 9000 --no-browser
    """
    allowed = list(roots or [])
    folders = [(root, "folder of videos") for root in allowed]
    if models is not None:
        folders.append((models, "folder of models"))
    for folder, what in folders:
        if not existing(folder, what).is_dir():
            raise InputError(f"Expected a {what}, but {folder} is a file. Name the folder that it lies in.")
    if video is not None:
        from tsr_engine.io.video_probe import check_file

        check_file(video)
        allowed.append(video.resolve().parent)
    from app.settings import load_settings

    settings = load_settings(
        home=home,
        roots=tuple(allowed or [Path.cwd()]) if allowed or roots else None,
        host=host,
        port=port,
        database_url=database,
        workers=workers,
        cores=cores,
        models=models,
        sample=sample,
    )
    from app.cli.serve import open_running, serve

    asked = {
        "--root": roots,
        "--host": host,
        "--port": port,
        "--database": database,
        "--workers": workers,
        "--cores": cores,
        "--models": models,
        "--sample/--no-sample": sample,
    }
    if open_running(settings, video, browser, [name for name, value in asked.items() if value is not None]):
        return
    serve(settings, video, browser)
