"""The process that cages are forked from: it loads everything once, so a cage starts within milliseconds.

``python -m app.cages.nursery`` reads a socket as its standard input. Each byte brings one end of a connection. The
process forked for it sends its process id, receives its task, confines itself and does the task. The nursery has a
single thread that lives as long as the process: the kernel kills the cages when the nursery ends, and the nursery ends
when the server, or the kernel for it, closes the socket.
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

from app.cages.confine import confine, die_with_parent
from app.cages.failures import report
from app.cages.limits import Limits
from app.cages.talk import Ended, Talk

__all__: list[str] = []

_LOADED: Final = (
    "app.exchange.caged:rehearse",
    "app.bundles.checking",
    "app.videos.decoding",
)
"""Modules that cages need, loaded with all their imports; ``module:function`` also calls a function whose first call is
slow.
"""


def main() -> None:
    """Fork a cage for each request until the socket is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; the server ends us
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    own = os.getpid()
    for name in _LOADED:
        module, _, function = name.partition(":")
        loaded = importlib.import_module(module)
        if function:
            getattr(loaded, function)()
    gc.collect()
    gc.freeze()  # never collected, so its pages stay shared
    with socket.socket(fileno=os.dup(0)) as orders:
        while True:
            said, ends, _, _ = socket.recv_fds(orders, 1, 1)
            if not said:
                return
            if os.fork() == 0:
                orders.close()
                os.close(0)
                _serve(own, socket.socket(fileno=ends[0]))
            os.close(ends[0])


def _serve(parent: int, end: socket.socket) -> None:
    """Run as one cage until the process ends."""
    code = 1
    try:
        if die_with_parent(parent):
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            talk = Talk(end)
            talk.send({"number": os.getpid()})
            task, content = talk.receive()
            limits, arguments = pickle.loads(content)  # noqa: S301 - the server's own words
            _do(talk, str(task["function"]), limits, arguments)
            code = 0
    except Ended:
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(code)


def _do(talk: Talk, name: str, limits: Limits, arguments: tuple[object, ...]) -> None:
    module, _, function = name.partition(":")
    do = getattr(importlib.import_module(module), function)
    confine(limits)
    try:
        found = do(talk, *arguments)
    except Ended:
        raise
    except Exception as error:
        talk.send({"failed": report(error)})
        return
    talk.send({"found": found})


if __name__ == "__main__":
    main()
