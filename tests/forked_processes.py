"""The Python processes that a server starts, forked from one that has loaded their modules."""

from __future__ import annotations

import ctypes
import gc
import os
import pickle
import runpy
import socket
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from app.sandbox.confine import die_with_parent

__all__ = ["fork_processes"]

_ADOPTS = 36
"""PR_SET_CHILD_SUBREAPER: orphans among the descendants become children."""
_LONGEST = 2**20
"""The longest order, bytes."""
_OWN = (0, 1, 2)
"""Standard input, output and errors."""
_end = os._exit
"""Ends a forked process without the clean-up of the process that it was forked from."""


def fork_processes() -> None:
    """From now on this process forks what it starts as ``python -m``; call it before there is a second thread.

    A process without threads does the forking. What it forks becomes a child of this process, like any it starts.
    """
    ctypes.CDLL(None).prctl(_ADOPTS, 1, 0, 0, 0)
    server = os.getpid()
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    if os.fork() == 0:
        ours.close()
        _fork_all(server, theirs)
    theirs.close()
    lock = threading.Lock()

    class Forked(subprocess.Popen[Any]):
        """A process of that kind; its parts are those of one that was started."""

        def _execute_child(self, args: Sequence[str], *how: Any) -> None:
            if list(args[:2]) != [sys.executable, "-m"]:
                super()._execute_child(args, *how)  # type: ignore[misc]
                return
            folder, environment, pipes = how[4], how[5], how[9:15]
            ends = [own if end == -1 else end for own, end in zip(_OWN, (pipes[0], pipes[3], pipes[5]), strict=True)]
            order = pickle.dumps((args[2:], str(folder or Path.cwd()), dict(environment or os.environ)))
            with lock:
                socket.send_fds(ours, [order], ends)
                self.pid = int(ours.recv(32))
            self._child_created = True
            self._close_pipe_fds(*pipes)  # type: ignore[attr-defined]

    subprocess.Popen = Forked  # type: ignore[misc]


def _fork_all(server: int, orders: socket.socket) -> NoReturn:
    """Fork one process for each order, until the server ends."""
    if not die_with_parent(server):
        _end(0)
    gc.freeze()  # never collected, so its pages stay shared
    while True:
        order, ends, _, _ = socket.recv_fds(orders, _LONGEST, len(_OWN))
        if not order:
            _end(0)
        between = os.fork()
        if between == 0:
            between = os.getpid()
            made = os.fork()
            if made == 0:
                orders.close()
                _be(between, ends, *pickle.loads(order))
            orders.send(str(made).encode())
            _end(0)
        os.waitpid(between, 0)
        for end in ends:
            os.close(end)


def _be(
    between: int, ends: Sequence[int], command: Sequence[str], folder: str, environment: dict[str, str]
) -> NoReturn:
    """Behave like a process that was started with this command."""
    code = 1
    try:
        for own, end in zip(_OWN, ends, strict=True):
            os.dup2(end, own)
        for end in ends:
            os.close(end)
        os.environ.clear()
        os.environ.update(environment)
        os.chdir(folder)
        while os.getppid() == between:  # the parent ends, and the server takes its place
            time.sleep(0.001)
        sys.argv = list(command)
        runpy.run_module(command[0], run_name="__main__", alter_sys=True)
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        _end(code)
