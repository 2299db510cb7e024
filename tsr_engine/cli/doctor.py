"""`tsr doctor`: what is installed, what is missing, and how to get it."""

from __future__ import annotations

from dataclasses import asdict

import typer

from tsr_engine.cli.common import JsonOption, ModelsOption, out_console, print_json

_MARKS = {"ok": "[green]ok[/green]", "warning": "[yellow]warning[/yellow]", "missing": "[red]missing[/red]"}


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
        from rich.markup import escape
        from rich.table import Table

        table = Table(box=None, pad_edge=False)
        for column in ("", "what", "found", "how to get it"):
            table.add_column(column, overflow="fold")
        for check in checks:
            table.add_row(_MARKS[check.status], escape(check.name), escape(check.found), escape(check.advice))
        out_console().print(table)
    if any(check.status == "missing" for check in checks):
        raise typer.Exit(4)
