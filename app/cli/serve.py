"""Starts the server, or finds the one that is running."""

from __future__ import annotations

import asyncio
import fcntl
import gc
import json
import os
import socket
import threading
import time
import urllib.error
import urllib.request
import webbrowser
from collections.abc import Sequence
from pathlib import Path
from types import FrameType
from typing import Any, cast

import uvicorn
from fastapi import FastAPI

from app.main import create_app
from app.security.tokens import home_token
from app.security.wire import Door
from app.settings import Settings
from app.storage.database import sqlite_file
from tsr_engine.cli.common import say
from tsr_engine.errors import StorageError, UsageError
from tsr_engine.io.atomic import atomic_text
from tsr_engine.io.locks import is_locked

__all__ = ["ReviewServer", "open_running", "serve", "serving", "show_link"]

_LOCK = "server.lock"
_RUNNING = "server.json"
_START = 20.0
"""Seconds that another server has to come up before it counts as stuck."""


class ReviewServer(uvicorn.Server):
    """Shuts down in order and soon, however often Ctrl-C is pressed, and then returns to the caller."""

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Remember the signal. Uvicorn would raise it once more at the end, and drop everything at a second one."""
        self.should_exit = True

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Stop serving: first the streams of events, which never end by themselves, and what reads foreign files."""
        state = cast(FastAPI, self.config.app).state
        await state.running.stream.stop()
        state.context.cages.close()
        await super().shutdown(sockets)


def serving(app: FastAPI, door: Door | None = None, **options: Any) -> uvicorn.Config:
    """How uvicorn serves the application; ``options`` are further ones of ``uvicorn.Config``."""
    protocol = cast(type[asyncio.Protocol], (door or Door()).protocol)
    return uvicorn.Config(
        app,
        http=protocol,
        timeout_graceful_shutdown=2,
        server_header=False,
        proxy_headers=False,  # the address of a proxy counts (app.security.proxies), not the one that it forwards
        lifespan="on",
        **options,
    )


def serve(settings: Settings, video: Path | None, browser: bool) -> None:
    """Run the server until Ctrl-C, as the last thing that this process does.

    Raises:
        UsageError: the port is taken.
        StorageError: another server uses the data folder or its SQLite database, or they cannot be written.
    """
    locks = _only_one(settings)
    note = settings.home / _RUNNING
    note.unlink(missing_ok=True)  # of a server that was killed
    listener = _listen(settings)
    port = listener.getsockname()[1]
    base = f"http://{_shown(settings.host)}:{port}"
    app = create_app(settings.model_copy(update={"port": port}))
    context = app.state.context
    context.cages.warm()
    with atomic_text(note) as file:
        json.dump({"base": base, "pid": os.getpid()}, file)
    path = ""
    if video is not None:
        added = context.videos.add_path(str(video.resolve()))
        path = f"#/review/{added.id}"
    link = f"{base}{context.way_in()}{path}"
    server = ReviewServer(serving(app, log_level="warning", access_log=False))
    threading.Thread(target=_tell_when_ready, args=(server, settings, link, browser), daemon=True).start()
    try:
        server.run(sockets=[listener])
    finally:
        note.unlink(missing_ok=True)
        for lock in locks:
            os.close(lock)
        gc.freeze()  # the interpreter would look through all of it once more before it ends, for over a second


def open_running(settings: Settings, video: Path | None, browser: bool, options: Sequence[str] = ()) -> bool:
    """If a server runs on the data folder already, ask it for a fresh link; False: there is none.

    Args:
        settings: of this call.
        video: to be added and opened.
        browser: open the page.
        options: names of the options given that only a server that starts can follow.

    Raises:
        UsageError: it does not take the video.
    """
    until = time.monotonic() + _START
    # where no server holds the lock nobody is asked: the secret is not for whoever has the old port by now
    while is_locked(settings.home / _LOCK):
        try:
            link = _ask_for_link(settings, video)
        except urllib.error.HTTPError as error:
            raise UsageError(f"The running server refused: {_sentence(error)}") from None
        except (OSError, ValueError, KeyError):
            if time.monotonic() > until:
                return False
            time.sleep(0.2)  # it is just starting, or just ending
            continue
        say(f"A server runs on {settings.home} already.")
        if options:
            say(f"warning: {', '.join(options)} changes nothing there. End that server first, then start it so.")
        _say_link(settings, link)
        if browser:
            show_link(link)
        return True
    return False


def _ask_for_link(settings: Settings, video: Path | None) -> str:
    base = json.loads((settings.home / _RUNNING).read_text(encoding="utf-8"))["base"]
    token = settings.token or home_token(settings.home)
    path = ""
    if video is not None:
        added = _post(f"{base}/api/videos", token, {"path": str(video.resolve())})
        path = f"#/review/{added['id']}"
    return f"{base}{_post(f'{base}/api/session/links', token, None)['path']}{path}"


def _post(url: str, token: str, body: dict[str, str] | None) -> dict[str, str]:
    data = json.dumps(body).encode() if body is not None else b""
    headers = {"Authorization": f"Bearer {token}", "Content-Type": "application/json"}
    request = urllib.request.Request(url, data=data, headers=headers, method="POST")  # noqa: S310 - our own server
    with urllib.request.urlopen(request, timeout=60) as answer:  # noqa: S310
        found: dict[str, str] = json.load(answer)
        return found


def _sentence(error: urllib.error.HTTPError) -> str:
    try:
        return str(json.load(error)["error"]["message"])
    except (ValueError, KeyError, TypeError):
        return str(error)


def _only_one(settings: Settings) -> list[int]:
    """Locks on the data folder and its SQLite file, freed by the kernel when this process ends.

    The file has one of its own, for a server with another data folder can be pointed at it. Which jobs are alive is
    told by locks in the data folder, so to each of two servers all jobs of the other would be dead.
    """
    home = settings.home
    database = sqlite_file(settings.database)
    try:
        home.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StorageError(f"Cannot use the data folder {home}: {error.strerror}. Choose another --home.") from None
    locks = [_lock(home / _LOCK, f"the data folder {home}", "--home")]
    if database is not None:
        place = database.with_name(f"{database.name}.lock")
        locks.append(_lock(place, f"the database {database}", "--home" if database.parent == home else "--database"))
    return locks


def _lock(place: Path, what: str, option: str) -> int:
    try:
        file = os.open(place, os.O_RDWR | os.O_CREAT, 0o600)
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise StorageError(f"Another server uses {what}. Use its page, or choose another {option}.") from None
    except OSError as error:
        raise StorageError(f"Cannot use {what}: {error.strerror}. Choose another {option}.") from None
    return file


def _listen(settings: Settings) -> socket.socket:
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((settings.host, settings.port))
    except OSError as error:
        listener.close()
        raise UsageError(
            f"Cannot listen on {settings.host}:{settings.port}: {error.strerror}. Choose another --port, or 0 for any."
        ) from None
    listener.set_inheritable(False)
    return listener


def _shown(host: str) -> str:
    name = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(host, host)  # noqa: S104 - compared, not bound
    return f"[{name}]" if ":" in name and not name.startswith("[") else name


def _tell_when_ready(server: uvicorn.Server, settings: Settings, link: str, browser: bool) -> None:
    """The link is reported once it can be opened."""
    until = time.monotonic() + 60
    while not server.started and time.monotonic() < until:
        time.sleep(0.02)
    _say_link(settings, link)
    say("Press Ctrl-C to stop. Everything is stored as it happens.")
    if browser:
        show_link(link)


def show_link(link: str) -> None:
    """Open a page in the browser, or say that there is none."""
    if not webbrowser.open(link):
        say("No browser was found here. Open the address above in one.")


def _say_link(settings: Settings, link: str) -> None:
    """Print where the page is."""
    say(f"tsr review on {link}")
    if "/login/" not in link:
        say("People sign in there with their token ('tsr people add' makes accounts).")
    elif not settings.loopback:
        say(f"Others can reach {settings.host}: the link lets one of them in, once.")
    if settings.everywhere:
        say("From another machine, put this machine's address in its place, or a name of TSR_ALLOWED_HOSTS.")
