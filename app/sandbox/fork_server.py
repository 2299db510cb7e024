"""The process that sandboxes are forked from: it loads everything once, so a sandbox starts within milliseconds.

``python -m app.sandbox.fork_server`` reads a socket as its standard input. Each byte brings one end of a connection.
The process forked for it sends its process id, receives its task, confines itself and does the task. The fork server
has a single thread that lives as long as the process: the kernel kills the sandboxes when the fork server ends, and the
fork server ends when the server, or the kernel for it, closes the socket.
"""

from __future__ import annotations

import gc
import importlib
import os
import pickle
import signal
import socket
import sys
import traceback
from typing import Final

from app.sandbox.channel import Channel, ChannelClosed
from app.sandbox.confine import confine, die_with_parent
from app.sandbox.failures import encode_failure
from app.sandbox.limits import Limits

_PRELOADED: Final = ("app.exchange.sandboxed_imports:warm_up", "app.bundles.checking", "app.videos.decoding")
"""Modules that sandboxes need, loaded with all their imports; ``module:function`` also calls a function whose first
call is slow.
"""


def main() -> None:
    """Fork a sandbox for each request until the socket is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; the server ends us
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    parent = os.getpid()
    for name in _PRELOADED:
        module, _, function = name.partition(":")
        imported = importlib.import_module(module)
        if function:
            getattr(imported, function)()
    gc.collect()
    gc.freeze()  # never collected, so its pages stay shared
    with socket.socket(fileno=os.dup(0)) as control:
        while True:
            data, files, _, _ = socket.recv_fds(control, 1, 1)
            if not data:
                return
            if os.fork() == 0:
                control.close()
                os.close(0)
                _serve(parent, socket.socket(fileno=files[0]))
            os.close(files[0])


def _serve(parent: int, connection: socket.socket) -> None:
    """Run as one sandbox until the process ends."""
    code = 1
    try:
        if die_with_parent(parent):
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            channel = Channel(connection)
            channel.send({"pid": os.getpid()})
            task, content = channel.receive()
            limits, arguments = pickle.loads(content)  # noqa: S301 - sent by the server
            _run_task(channel, str(task["function"]), limits, arguments)
            code = 0
    except ChannelClosed:
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(code)


def _run_task(channel: Channel, name: str, limits: Limits, arguments: tuple[object, ...]) -> None:
    module, _, function = name.partition(":")
    run = getattr(importlib.import_module(module), function)
    confine(limits)
    try:
        result = run(channel, *arguments)
    except ChannelClosed:
        raise
    except Exception as error:
        channel.send({"failed": encode_failure(error)})
        return
    channel.send({"result": result})


if __name__ == "__main__":
    main()
