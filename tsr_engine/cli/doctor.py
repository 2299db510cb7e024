"""`tsr doctor`: what is installed, what is missing, and how to get it."""

from __future__ import annotations

from dataclasses import asdict

import typer

from tsr_engine.cli.common import JsonOption, ModelsOption, out_console, print_json

_COLOURS = {"ok": "green", "warning": "yellow", "missing": "red"}


def doctor(models: ModelsOption = None, as_json: JsonOption = False) -> None:
    """Show versions, codecs, models and cores, and how to get what is missing.

    The exit code is 4 if something is missing that a command needs.

    Example: tsr doctor --json
    """
    from tsr_engine.cli.diagnosis import diagnose

    checks = diagnose(models)
    if as_json:
        print_json([asdict(check) for check in checks])
    else:
        from rich.table import Table
        from rich.text import Text

        table = Table(box=None, pad_edge=False)
        for column in ("", "what", "found", "how to get it"):
            table.add_column(column, overflow="fold")
        for check in checks:
            mark = Text(check.status, _COLOURS[check.status])
            table.add_row(mark, check.name, check.found, check.advice)
        out_console().print(table)
    if any(check.status == "missing" for check in checks):
        raise typer.Exit(4)
