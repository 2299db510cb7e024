"""Starts the server, or finds the running one."""

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

from app.cli.run_names import as_command_error
from app.main import create_app
from app.security.connections import ConnectionLimits
from app.security.tokens import home_token
from app.settings import Settings
from app.storage.database import sqlite_file
from tsr_engine.cli.common import say
from tsr_engine.errors import StorageError, UsageError
from tsr_engine.io.atomic import atomic_text
from tsr_engine.io.locks import is_locked

_LOCK = "server.lock"
_RUNNING = "server.json"
_START_TIMEOUT_S = 20.0
"""Seconds that another server may take to start before it counts as stuck."""


class ReviewServer(uvicorn.Server):
    """Shuts down in order and soon, even if Ctrl-C is pressed again, and then returns to the caller."""

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Remember the signal. Uvicorn would raise it again at the end, and stop at once at a second one."""
        self.should_exit = True

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Stop serving: first the event streams, which never end by themselves, and the sandboxes."""
        state = cast(FastAPI, self.config.app).state
        await state.running.stream.stop()
        state.context.sandboxes.close()
        await super().shutdown(sockets)


# Any: the options have different types
def server_config(app: FastAPI, limits: ConnectionLimits | None = None, **options: Any) -> uvicorn.Config:
    """Configure uvicorn for the application; ``options`` are further arguments of ``uvicorn.Config``."""
    protocol = cast(type[asyncio.Protocol], (limits or ConnectionLimits()).protocol)
    return uvicorn.Config(
        app,
        http=protocol,
        timeout_graceful_shutdown=2,
        server_header=False,
        proxy_headers=False,  # app.security.proxies needs the address of the proxy, not the one that it forwards
        lifespan="on",
        **options,
    )


def serve(settings: Settings, video: Path | None, browser: bool) -> None:
    """Run the server until Ctrl-C; the last action of this process.

    Raises:
        UsageError: the port is taken, or the video's path is not allowed.
        InputError: the video cannot be added.
        StorageError: another server uses the data folder or its SQLite database, or they cannot be written.
    """
    locks = _lock_data(settings)
    note = settings.home / _RUNNING
    note.unlink(missing_ok=True)  # left by a server that was killed
    listener = _listen(settings)
    port = listener.getsockname()[1]
    base = f"http://{_host_in_url(settings.host)}:{port}"
    app = create_app(settings.model_copy(update={"port": port}))
    context = app.state.context
    path = ""
    if video is not None:
        with as_command_error():
            path = f"#/review/{context.videos.add_path(str(video.resolve())).id}"
    context.sandboxes.warm()
    with atomic_text(note) as file:
        json.dump({"base": base, "pid": os.getpid()}, file)
    link = f"{base}{context.sign_in_path()}{path}"
    server = ReviewServer(server_config(app, log_level="warning", access_log=False))
    threading.Thread(target=_print_link_when_ready, args=(server, settings, link, browser), daemon=True).start()
    gc.freeze()  # a search for garbage among loaded modules finds none, and all requests wait for it
    try:
        server.run(sockets=[listener])
    finally:
        note.unlink(missing_ok=True)
        for lock in locks:
            os.close(lock)
        gc.freeze()  # otherwise the interpreter collects all of it at exit, which takes over a second


def open_running(settings: Settings, video: Path | None, browser: bool, options: Sequence[str] = ()) -> bool:
    """If a server already runs on the data folder, open a fresh link to it; False if there is none.

    Args:
        settings: settings of this call.
        video: video to add and open.
        browser: open the page.
        options: given options that only affect a server that starts.

    Raises:
        UsageError: the server refuses the video.
    """
    until = time.monotonic() + _START_TIMEOUT_S
    # Without a lock no server runs here: its old port may belong to a stranger, who must not get the secret.
    while is_locked(settings.home / _LOCK):
        try:
            link = _ask_for_link(settings, video)
        except urllib.error.HTTPError as error:
            raise UsageError(f"The running server refused: {_error_message(error)}") from None
        except (OSError, ValueError, KeyError):
            if time.monotonic() > until:
                return False
            time.sleep(0.2)  # it is starting or ending
            continue
        say(f"A server runs on {settings.home} already.")
        if options:
            say(f"warning: {', '.join(options)} has no effect there. Stop that server first, then start it with them.")
        _print_link(settings, link)
        if browser:
            open_link(link)
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


def _error_message(error: urllib.error.HTTPError) -> str:
    try:
        return str(json.load(error)["error"]["message"])
    except (ValueError, KeyError, TypeError):
        return str(error)


def _lock_data(settings: Settings) -> list[int]:
    """Lock the data folder and its SQLite file; the kernel frees the locks when this process ends.

    The SQLite file has a separate lock because a server with another data folder may use it too. Locks in the data
    folder also show which jobs are alive, so each of two servers would take the other's jobs for dead.
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
        if database.exists() and not os.access(database, os.W_OK, effective_ids=True):
            raise StorageError(f"The database {database} cannot be written. Give the file to the user of the server.")
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


def _host_in_url(host: str) -> str:
    name = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(host, host)  # noqa: S104 - compared, not bound
    return f"[{name}]" if ":" in name and not name.startswith("[") else name


def _print_link_when_ready(server: uvicorn.Server, settings: Settings, link: str, browser: bool) -> None:
    """Print the link when the server accepts connections."""
    until = time.monotonic() + 60
    while not server.started and time.monotonic() < until:
        time.sleep(0.02)
    _print_link(settings, link)
    say("Press Ctrl-C to stop. All changes are stored at once.")
    if browser:
        open_link(link)


def open_link(link: str) -> None:
    """Open a page in the browser, or say that there is no browser."""
    if not webbrowser.open(link):
        say("No browser was found. Open the address above in one.")


def _print_link(settings: Settings, link: str) -> None:
    """Print where the page is."""
    say(f"tsr review on {link}")
    if "/login/" not in link:
        say("People sign in there with their token ('tsr people add' makes accounts).")
    elif not settings.loopback:
        say(f"Others can reach {settings.host}: the link signs one of them in, once.")
    if settings.everywhere:
        say("From another machine, replace the host by this machine's address or a name in TSR_ALLOWED_HOSTS.")
