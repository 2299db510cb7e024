"""``tsr labels``: the label sets of a data folder, without a server."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.cli.attribute_option import ATTRIBUTE_HELP, parse_attribute
from app.cli.label_common import (
    FormatOption,
    LabelArgument,
    SetOption,
    change_labels,
    find_label,
    label_service,
    parse_set_key,
    written,
)
from app.cli.library import HomeOption
from tsr_engine.cli.common import JsonOption, out_console, print_json, say
from tsr_engine.errors import UsageError

app = typer.Typer(
    help="List, add and change the labels of a data folder; import and export label sets.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.command("list")
def listed(home: HomeOption = None, set_key: SetOption = None, json: JsonOption = False) -> None:
    """List the labels of a set, and all sets; a star marks the library's set.

    \b
    Example:
      tsr labels list --home out/review
    """
    with label_service(home) as (service, _):
        labels, sets = service.get(set_key), service.sets()
        views = service.views(labels)
    if json:
        print_json(
            {
                "set": labels.key,
                "version": labels.version,
                "labels": [view.model_dump(mode="json") for view in views],
                "sets": [each.model_dump(mode="json") for each in sets],
            }
        )
        return
    from rich.table import Table
    from rich.text import Text

    table = Table("id", "key", "name", "aliases", "attributes", "teach", "", box=None, pad_edge=False)
    for view in views:
        state = f"merged into {view.merged_into}" if view.merged_into is not None else "hidden" if view.hidden else ""
        attributes = ", ".join(attribute.name for attribute in view.attributes)
        words = (str(view.id), view.key, view.name, ", ".join(view.aliases), attributes, view.teach, state)
        table.add_row(*map(Text, words))
    out_console().print(table)
    table = Table("", "set", "name", "version", "labels", box=None, pad_edge=False)
    for each in sets:
        star = "*" if each.default else ""
        table.add_row(*map(Text, (star, each.key, each.name, str(each.version), str(each.labels))))
    out_console().print()
    out_console().print(table)


@app.command("show")
def show(label: LabelArgument, home: HomeOption = None, set_key: SetOption = None, json: JsonOption = False) -> None:
    """Show all fields of one label.

    \b
    Example:
      tsr labels show stop
    """
    with label_service(home) as (service, _):
        labels = service.get(set_key)
        (view,) = service.views(labels, [find_label(labels, label)])
    if json:
        print_json(view.model_dump(mode="json"))
        return
    from rich.text import Text

    for field, value in view.model_dump(mode="json").items():
        if value not in (None, "", [], False):
            out_console().print(Text(f"{field}: {written(value)}"))


@app.command("add")
def add(
    name: Annotated[str, typer.Argument(help="Display name.")],
    home: HomeOption = None,
    set_key: SetOption = None,
    key: Annotated[str | None, typer.Option("--key", help="Stable text.  [default: made from the name]")] = None,
    short: Annotated[str | None, typer.Option("--short", help="For pictures; at most 12 characters.")] = None,
    aliases: Annotated[list[str], typer.Option("--alias", help="Another name for it; repeatable.")] = [],  # noqa: B006
    shape: Annotated[str | None, typer.Option("--shape", help="triangle, circle, rectangle ...")] = None,
    category: Annotated[str | None, typer.Option("--category", help="prohibitory, danger, information ...")] = None,
    attributes: Annotated[list[str], typer.Option("--attribute", help=ATTRIBUTE_HELP)] = [],  # noqa: B006
    teach: Annotated[str | None, typer.Option("--teach", help="sign, background or ignore, for retraining.")] = None,
    colour: Annotated[str | None, typer.Option("--colour", help="#rrggbb.")] = None,
    digit: Annotated[int | None, typer.Option("--digit", min=1, max=9, help="Key that gives the label.")] = None,
    json: JsonOption = False,
) -> None:
    """Add a label.

    \b
    Example:
      tsr labels add "no parking" --alias Parkverbot --attribute 'occluded:checkbox,mutable'
    """
    facts: dict[str, object] = {"type": "add", "name": name, "key": key, "short": short, "shape": shape}
    facts |= {"category": category, "teach": teach, "colour": colour, "pinned": digit, "aliases": aliases or None}
    facts["attributes"] = [parse_attribute(text) for text in attributes] or None
    sent = {field: value for field, value in facts.items() if value is not None}
    with label_service(home) as (service, author):
        change_labels(service, set_key, author, sent, json)


@app.command("rename")
def rename(
    label: LabelArgument,
    name: Annotated[str, typer.Argument(help="New name.")],
    home: HomeOption = None,
    set_key: SetOption = None,
    json: JsonOption = False,
) -> None:
    """Rename a label; its key and number stay.

    \b
    Example:
      tsr labels rename give-way "yield"
    """
    with label_service(home) as (service, author):
        found = find_label(service.get(set_key), label)
        change_labels(service, set_key, author, {"type": "update", "id": found.id, "name": name}, json)


@app.command("alias")
def alias(
    label: LabelArgument,
    names: Annotated[list[str], typer.Argument(metavar="ALIAS...", help="Other names for it.")],
    home: HomeOption = None,
    set_key: SetOption = None,
    remove: Annotated[bool, typer.Option("--remove", help="Remove these aliases.")] = False,
    json: JsonOption = False,
) -> None:
    """Add aliases to a label; imports and searches find it by them.

    \b
    Example:
      tsr labels alias stop "stop sign" Stoppschild
    """
    with label_service(home) as (service, author):
        found = find_label(service.get(set_key), label)
        if remove:
            missing = [name for name in names if name not in found.aliases]
            if missing:
                raise UsageError(f"'{found.name}' has no alias {missing[0]!r}.")
            aliases = [name for name in found.aliases if name not in names]
        else:
            aliases = list(dict.fromkeys((*found.aliases, *names)))
        change_labels(service, set_key, author, {"type": "update", "id": found.id, "aliases": aliases}, json)


@app.command("merge")
def merge(
    label: LabelArgument,
    into: Annotated[str, typer.Argument(metavar="INTO", help="The label that replaces it.")],
    home: HomeOption = None,
    set_key: SetOption = None,
    json: JsonOption = False,
) -> None:
    """Replace one label by another; stored tracks are not rewritten, and undo brings it back.

    \b
    Example:
      tsr labels merge "no waiting" "no parking"
    """
    with label_service(home) as (service, author):
        labels = service.get(set_key)
        change = {"type": "merge", "id": find_label(labels, label).id, "into": find_label(labels, into).id}
        change_labels(service, set_key, author, change, json)


@app.command("hide")
def hide(
    label: LabelArgument,
    home: HomeOption = None,
    set_key: SetOption = None,
    undo: Annotated[bool, typer.Option("--undo", help="Offer it again.")] = False,
    json: JsonOption = False,
) -> None:
    """Stop offering a label; tracks that have it keep it.

    \b
    Example:
      tsr labels hide "no waiting"
    """
    with label_service(home) as (service, author):
        found = find_label(service.get(set_key), label)
        change_labels(service, set_key, author, {"type": "show" if undo else "hide", "id": found.id}, json)


@app.command("import")
def import_labels(
    file: Annotated[str, typer.Argument(metavar="FILE", help="A file of labels, or the key of a set such as vienna.")],
    home: HomeOption = None,
    set_key: SetOption = None,
    format: FormatOption = None,
    create: Annotated[bool, typer.Option("--create", help="Create the set of --set if there is none.")] = False,
    json: JsonOption = False,
) -> None:
    """Add the missing labels of a file or of another set; existing labels keep their numbers.

    \b
    Examples:
      tsr labels import vienna
      tsr labels import obj.names --set team --create
    """
    from app.labels.importing import import_file_labels
    from tsr_engine.exchange.label_files.formats import read_labels
    from tsr_engine.exchange.label_files.label_collector import FileLabels

    with label_service(home) as (service, author):
        target = service.get(None).key if set_key is None else set_key
        known = [each.key for each in service.sets()]
        if file in known and not Path(file).exists():
            found = FileLabels(service.get(file))
        else:
            if not Path(file).is_file():
                raise UsageError(f"Expected a file of labels or one of the sets {', '.join(known)}. Got {file!r}.")
            found = read_labels(Path(file), target, Path(file).name, format)
        done = import_file_labels(service, parse_set_key(target), author, found, create=create, file=Path(file).name)
    if json:
        print_json(done.model_dump(mode="json"))
        return
    say(f"{done.sentence} {len(done.known)} were already in the set." if done.added else done.sentence)
    for sentence in (*done.reported, *(each.reason for each in done.refused)):
        say(sentence)


@app.command("export")
def export_labels(
    out: Annotated[Path, typer.Argument(metavar="OUT", help="File to write.")],
    home: HomeOption = None,
    set_key: SetOption = None,
    format: Annotated[str, typer.Option("--format", help="tsr, cvat, names, yaml, coco or label-studio.")] = "tsr",
    version: Annotated[int | None, typer.Option("--version", min=1, help="An older version of the set.")] = None,
    json: JsonOption = False,
) -> None:
    """Write a set as a file of tsr or of another tool.

    \b
    Example:
      tsr labels export labels.json --format cvat
    """
    from tsr_engine.exchange.label_files.formats import LABEL_FORMATS, write_labels
    from tsr_engine.io.atomic import atomic_text

    if out == Path("-"):
        raise UsageError("Labels cannot be written to standard output. Name a file.")
    with label_service(home) as (service, _):
        labels = service.get(set_key, version)
        text = write_labels(labels, format)
    with atomic_text(out) as stream:
        stream.write(text)
    lost = LABEL_FORMATS[format].loses
    if json:
        print_json({"file": str(out), "format": format, "set": labels.key, "version": labels.version, "loses": lost})
        return
    say(f"Wrote {out}: '{labels.name}', version {labels.version}. {lost}".rstrip())


@app.command("use")
def use(
    key: Annotated[str, typer.Argument(metavar="SET", help="Key of a label set; with --video also 'default'.")],
    home: HomeOption = None,
    video: Annotated[str | None, typer.Option("--video", help="Name, path or id of one video.")] = None,
    json: JsonOption = False,
) -> None:
    """Set the label set of the library or of one video; refused if labels in use have another meaning there.

    \b
    Examples:
      tsr labels use vienna
      tsr labels use team --video drive.mp4
    """
    with label_service(home) as (service, _):
        if video is None:
            view = service.use_as_default(key)
            message = f"The library uses '{view.name}'."
        else:
            view = service.use_in_video(service.video_named(video), None if key == "default" else key)
            message = f"{video} uses '{view.name}'."
    if json:
        print_json(view.model_dump(mode="json"))
        return
    say(message)
