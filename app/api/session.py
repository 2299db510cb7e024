"""Sessions: sign in, sign out, and the rights of the page."""

from __future__ import annotations

from typing import Annotated

from fastapi import Request, Response
from pydantic import Field

from app.api.access import WhoDep
from app.api.responses import failures
from app.api.routing import api_router
from app.body_model import PLAIN, Model
from app.context import ContextDep
from app.errors import Unauthorised
from app.page_files import page_version, static_folder
from app.people.roles import Role
from app.security.access import sign_in_cookie
from tsr_engine.params.presets import PRESETS
from tsr_engine.version import __version__

router = api_router("session")


class Sample(Model):
    """The bundled drive that the first screen offers."""

    video_id: str
    run_id: str | None


class SignedIn(Model):
    """The person who is signed in."""

    name: str
    role: Role
    can_sign_out: bool
    """False: a proxy or a token identifies the person."""


class SessionAnswer(Model):
    """State that the page starts from."""

    version: str
    page: str
    """Version of the page's files, as in their addresses."""
    author: str
    """Name that edits carry unless the page sets another."""
    person: SignedIn | None
    """None: the library has no people, but one user."""
    roots: list[str]
    """Folders from which videos may be added."""
    upload_bytes: int
    """Largest upload."""
    sample: Sample | None
    """The bundled drive."""
    presets: list[str]


class SignIn(Model):
    """Credentials of a person."""

    token: Annotated[str, Field(min_length=1, max_length=200, pattern=PLAIN)]


class Link(Model):
    """A path that opens the page once."""

    path: str


@router.get("/session", operation_id="get_session", responses=failures())
def get_session(context: ContextDep, who: WhoDep) -> SessionAnswer:
    """Version, name, limits, and the sample drive."""
    sample = context.videos.sample()
    identity = who.identity
    person = None
    if not identity.owner:
        ends = context.directory.is_session(identity)
        person = SignedIn(name=identity.name or "the server", role=identity.role, can_sign_out=ends)
    return SessionAnswer(
        version=__version__,
        page=page_version(static_folder()),
        author=identity.name or context.settings.author,
        person=person,
        roots=[str(root) for root in context.settings.roots],
        upload_bytes=context.settings.upload_max_mb * 2**20,
        sample=None if sample is None else Sample(video_id=sample[0], run_id=sample[1]),
        presets=list(PRESETS),
    )


@router.post("/session", operation_id="sign_in", responses=failures(401))
def sign_in(wanted: SignIn, context: ContextDep, request: Request, response: Response) -> SignedIn:
    """Sign a browser in with a token. The response sets the cookie."""
    identity, secret = context.directory.sign_in(wanted.token.strip())
    if identity is None or identity.name is None:
        raise Unauthorised(
            "This token is wrong or has been revoked. Ask an administrator for a new one ('tsr people rotate')."
        )
    sign_in_cookie(request, response, secret)
    return SignedIn(name=identity.name, role=identity.role, can_sign_out=True)


@router.delete("/session", operation_id="sign_out", status_code=204, responses=failures())
def sign_out(context: ContextDep, who: WhoDep, request: Request, response: Response) -> None:
    """End the session of this browser."""
    context.directory.sign_out(who.identity)
    sign_in_cookie(request, response, "", 0)


@router.post("/session/links", operation_id="create_link", status_code=201, responses=failures())
def create_link(context: ContextDep) -> Link:
    """Create a one-time link, for a second browser or after a lost cookie. With people, it opens the sign-in page."""
    return Link(path=context.sign_in_path())
