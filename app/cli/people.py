"""``tsr people``: the accounts of a data folder, without a server; a running server applies changes at once."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

import json as json_format
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.library import HomeOption, open_library
from tsr_engine.cli.common import JsonOption, out_console, print_json, say
from tsr_engine.errors import UsageError
from tsr_engine.plural import plural

if TYPE_CHECKING:
    from app.people.box_agreement import BoxAgreements
    from app.people.roles import Role
    from app.people.service import PeopleService
    from app.settings import Settings

app = typer.Typer(
    help="List, add and remove the people of a data folder; set roles; create and revoke tokens.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

NameArgument = Annotated[str, typer.Argument(metavar="NAME", help="Name of the person, shown with their changes.")]
RoleOption = Annotated[
    str, typer.Option("--role", metavar="ROLE", help="admin, reviewer, annotator or viewer.", show_default=False)
]
UrlOption = Annotated[
    str | None,
    typer.Option(
        "--url", metavar="URL", help="Address of the server for people.  [default: that of the running server]"
    ),
]


@app.command("list")
def listed(home: HomeOption = None, json: JsonOption = False) -> None:
    """List the people with their roles and active tokens.

    \b
    Example:
      tsr people list --home out/review
    """
    with _service(home) as (service, _):
        people = [(view, service.tokens(view.name)) for view in service.views()]
    if json:
        rows = [{**view.model_dump(), "tokens": [token.model_dump() for token in found]} for view, found in people]
        print_json({"people": rows})
        return
    if not people:
        say("There are no people: the library has one user, who does not sign in. 'tsr people add' adds the first.")
        return
    from rich.table import Table
    from rich.text import Text

    table = Table("name", "role", "since", "assigned", "tokens", box=None, pad_edge=False)
    for view, found in people:
        texts = ", ".join(f"{token.id} ({token.note})" if token.note else token.id for token in found)
        table.add_row(*map(Text, (view.name, view.role, view.created[:10], str(view.assignments), texts or "none")))
    out_console().print(table)


@app.command("add")
def add(
    name: NameArgument, role: RoleOption, home: HomeOption = None, url: UrlOption = None, json: JsonOption = False
) -> None:
    """Add a person and print their sign-in link and token once.

    \b
    Example:
      tsr people add Ada --role admin --url https://tsr.example
    """
    chosen = _role(role)
    with _service(home) as (service, settings):
        first = not service.views()
        view, token = service.add(name, chosen)
        _print_token(settings, view.name, token, url, json)
    if first:
        say("From now on everybody signs in: the library has people.")
        if view.role != "admin":
            say(f"warning: {view.name} is not an administrator, and there is nobody else. Add one with --role admin.")


@app.command("remove")
def remove(name: NameArgument, home: HomeOption = None) -> None:
    """Remove a person with their tokens and assignments; their changes keep the name.

    \b
    Example:
      tsr people remove Ada --home out/review
    """
    with _service(home) as (service, _):
        service.remove(name)
        last = not service.views()
    say(f"{name} is removed and signed out.")
    if last:
        say("No people are left: the library has one user again, who opens the link of 'tsr review'.")


@app.command("role")
def role(
    name: NameArgument,
    role: Annotated[str, typer.Argument(metavar="ROLE", help="admin, reviewer, annotator or viewer.")],
    home: HomeOption = None,
) -> None:
    """Change a person's role, effective at once.

    \b
    Example:
      tsr people role Ada reviewer --home out/review
    """
    with _service(home) as (service, _):
        view = service.set_role(name, _role(role))
    say(f"{view.name} has the role {view.role}.")


@app.command("token")
def token(
    name: NameArgument,
    note: Annotated[str, typer.Option("--note", help="What the token is for.")] = "",
    home: HomeOption = None,
    url: UrlOption = None,
    json: JsonOption = False,
) -> None:
    """Create another token for a person, such as for a script or a second machine, and print it once.

    \b
    Example:
      tsr people token Ada --note "nightly export"
    """
    with _service(home) as (service, settings):
        _print_token(settings, name, service.new_token(name, note), url, json)


@app.command("rotate")
def rotate(name: NameArgument, home: HomeOption = None, url: UrlOption = None, json: JsonOption = False) -> None:
    """Revoke all tokens of a person, end their sessions, and print a new token once.

    \b
    Example:
      tsr people rotate Ada --home out/review
    """
    with _service(home) as (service, settings):
        _print_token(settings, name, service.rotate(name), url, json)


@app.command("revoke")
def revoke(
    name: NameArgument,
    token: Annotated[
        str | None, typer.Option("--token", metavar="ID", help="Only this token, as 'tsr people list' names it.")
    ] = None,
    home: HomeOption = None,
) -> None:
    """Revoke the tokens of a person, or one of them, and end their sessions and open pages.

    \b
    Example:
      tsr people revoke Ada --token 3f9ab812
    """
    with _service(home) as (service, _):
        count = service.revoke(name, token)
    say(f"{plural(count, 'token')} of {name} {'is' if count == 1 else 'are'} revoked, and {name} is signed out.")


@app.command("agreement")
def agreement(home: HomeOption = None, json: JsonOption = False) -> None:
    """Measure how well two people agree, by label and by person: on labels of sampled tracks, and on boxes.

    \b
    Example:
      tsr people agreement --home out/review
    """
    from app.events import EventBus
    from app.people.second_opinion import SecondOpinionService

    with open_library(home) as (_, database):
        report = SecondOpinionService(database, EventBus()).report()
    if json:
        print_json(report.model_dump(mode="json"))
        return
    from rich.table import Table
    from rich.text import Text

    _print_boxes(report.boxes)
    if report.whole.looked == 0:
        say(f"No second opinion has been answered; {report.open} are open. A reviewer assigns them on the page Team.")
        return
    table = Table("of", "", "looked at", "same answer", "share", "95 % interval", box=None, pad_edge=False)
    kinds = (
        ("", [report.whole]),
        ("label", report.labels),
        ("accepted by", report.first),
        ("looked at by", report.second),
    )
    for kind, rows in kinds:
        for one in rows:
            share = f"{100 * one.agreed / one.looked:.1f} %", f"{100 * one.low:.1f} % to {100 * one.high:.1f} %"
            table.add_row(*map(Text, (one.name, kind, str(one.looked), str(one.agreed), *share)))
    out_console().print(table)
    say(f"{plural(report.disputed, 'track')} in dispute, {report.open} to be looked at.")


def _print_boxes(boxes: BoxAgreements) -> None:
    """Print the agreement of boxes of two people, if there is any."""
    if boxes.whole.tracks == 0:
        return
    from rich.table import Table
    from rich.text import Text

    table = Table("boxes of", "", "tracks", "frames", "mean IoU", "95 % interval", box=None, pad_edge=False)
    kinds = ("", [boxes.whole]), ("label", boxes.labels), ("drawn by", boxes.first), ("drawn anew by", boxes.second)
    for kind, rows in kinds:
        for one in rows:
            figures = str(one.tracks), str(one.frames), f"{one.iou:.3f}", f"{one.low:.3f} to {one.high:.3f}"
            table.add_row(*map(Text, (one.name, kind, *figures)))
    out_console().print(table)


@contextmanager
def _service(home: Path | None) -> Iterator[tuple[PeopleService, Settings]]:
    """Open the service on an existing data folder; its refusals become errors of the command line."""
    from app.events import EventBus
    from app.people.service import PeopleService

    with open_library(home) as (settings, database):
        yield PeopleService(database, EventBus()), settings


def _role(text: str) -> Role:
    from app.people.roles import role_of

    try:
        return role_of(text)
    except ValueError as error:
        raise UsageError(str(error)) from None


def _print_token(settings: Settings, name: str, token: str, url: str | None, json: bool) -> None:
    """Print a token, which is stored nowhere; the part of a link after # never reaches a server or its log."""
    link = f"{(url or _server_address(settings)).rstrip('/')}/sign-in#{token}"
    if json:
        print_json({"name": name, "token": token, "link": link})
        return
    say(f"{name} signs in with this link, or with the token at its end. Both are shown only once.")
    out_console().print(link, soft_wrap=True, markup=False, highlight=False)


def _server_address(settings: Settings) -> str:
    try:
        return str(json_format.loads((settings.home / "server.json").read_text(encoding="utf-8"))["base"])
    except (OSError, ValueError, KeyError):
        return f"http://127.0.0.1:{settings.port}"
