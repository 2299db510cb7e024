"""`tsr params`: every parameter with its default, range and meaning."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

from typing import Annotated

import typer

from tsr_engine.cli.common import JsonOption, PresetOption, out_console, print_json


def params(
    preset: PresetOption = "default",
    json: JsonOption = False,
    changed: Annotated[bool, typer.Option("--changed", help="Only those that the preset changes.")] = False,
) -> None:
    """List every parameter: name, value in the preset, allowed values, meaning.

    \b
    Examples:
      tsr params
      tsr params --preset paper --changed
      tsr params --json | jq '.[].name'
    """
    from tsr_engine.params.parameter_table import parameter_rows

    rows = parameter_rows(preset)
    if changed:
        rows = [row for row in rows if row["value"] != row["default"]]
    if json:
        print_json(rows)
        return
    from rich.table import Table

    table = Table("section", "name", preset, "allowed", "meaning", box=None, pad_edge=False)
    for row in rows:
        table.add_row(*(str(row[key]) for key in ("section", "name", "value", "range", "description")))
    out_console().print(table)
