"""Start the server, or find the one that runs already."""

from __future__ import annotations

import fcntl
import json
import os
import socket
import threading
import time
import urllib.error
import urllib.request
import webbrowser
from pathlib import Path
from typing import cast

import uvicorn
from fastapi import FastAPI

from app.cli.review import say_link
from app.main import create_app
from app.security.tokens import home_token
from app.settings import Settings
from tsr_engine.cli.common import say
from tsr_engine.errors import StorageError, UsageError

__all__ = ["ReviewServer", "open_running", "serve"]

_RUNNING = "server.json"


class ReviewServer(uvicorn.Server):
    """Ends the streams of events before it waits for open requests to end, for those never end by themselves."""

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Stop serving."""
        await cast(FastAPI, self.config.app).state.running.stream.stop()
        await super().shutdown(sockets)


def serve(settings: Settings, video: Path | None, browser: bool) -> None:
    """Run the server until Ctrl-C.

    Raises:
        UsageError: the port is taken.
        StorageError: another server uses the data folder, or it cannot be written.
    """
    lock = _only_one(settings.home)
    listener = _listen(settings)
    port = listener.getsockname()[1]
    base = f"http://{_shown(settings.host)}:{port}"
    app = create_app(settings.model_copy(update={"port": port}))
    context = app.state.context
    note = settings.home / _RUNNING
    note.write_text(json.dumps({"base": base, "pid": os.getpid()}), encoding="utf-8")
    path = ""
    if video is not None:
        added = context.videos.add_path(str(video.resolve()))
        path = f"#/review/{added.id}"
    link = f"{base}/login/{context.tokens.new_link()}{path}"
    config = uvicorn.Config(
        app, log_level="warning", access_log=False, timeout_graceful_shutdown=2, server_header=False, lifespan="on"
    )
    server = ReviewServer(config)
    threading.Thread(target=_tell_when_ready, args=(server, settings, link, browser), daemon=True).start()
    try:
        server.run(sockets=[listener])
    finally:
        note.unlink(missing_ok=True)
        os.close(lock)


def open_running(settings: Settings, video: Path | None, browser: bool) -> bool:
    """If a server runs on the data folder already, ask it for a fresh link; False: there is none."""
    try:
        base = json.loads((settings.home / _RUNNING).read_text(encoding="utf-8"))["base"]
        token = settings.token or home_token(settings.home)
        path = ""
        if video is not None:
            added = _post(f"{base}/api/videos", token, {"path": str(video.resolve())})
            path = f"#/review/{added['id']}"
        answer = _post(f"{base}/api/session/links", token, None)
    except urllib.error.HTTPError as error:
        raise UsageError(f"The running server refused: {_sentence(error)}") from None
    except (OSError, ValueError, KeyError):
        return False
    link = f"{base}{answer['path']}{path}"
    say(f"A server runs on {settings.home} already.")
    say_link(settings, link)
    if browser:
        webbrowser.open(link)
    return True


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


def _only_one(home: Path) -> int:
    """A lock on the data folder, freed by the kernel when this process ends."""
    try:
        home.mkdir(parents=True, exist_ok=True)
        file = os.open(home / "server.lock", os.O_RDWR | os.O_CREAT, 0o600)
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise StorageError(f"Another server uses {home}. Use its page, or choose another --home.") from None
    except OSError as error:
        raise StorageError(f"Cannot use the data folder {home}: {error.strerror}. Choose another --home.") from None
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
    """The link is told once it can be opened."""
    until = time.monotonic() + 60
    while not server.started and time.monotonic() < until:
        time.sleep(0.02)
    say_link(settings, link)
    if browser:
        webbrowser.open(link)
