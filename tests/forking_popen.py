"""The Python processes that a server starts, forked from one that has loaded their modules."""

from __future__ import annotations

import ctypes
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

__all__ = ["install_forking_popen"]

_PR_SET_CHILD_SUBREAPER = 36
"""PR_SET_CHILD_SUBREAPER: orphans among the descendants become children."""
_MAX_REQUEST_BYTES = 2**20
"""The longest order, bytes."""
_STANDARD_FDS = (0, 1, 2)
"""Standard input, output and errors."""
_exit = os._exit
"""Ends a forked process without the clean-up of the process that it was forked from."""


def install_forking_popen() -> None:
    """From now on this process forks what it starts as ``python -m``; call it before there is a second thread.

    A process without threads does the forking. What it forks becomes a child of this process, like any it starts.
    """
    ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    server = os.getpid()
    client_end, server_end = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    if os.fork() == 0:
        client_end.close()
        _serve_forks(server, server_end)
    server_end.close()
    lock = threading.Lock()

    class ForkingPopen(subprocess.Popen[Any]):
        """A process of that kind; its parts are those of one that was started."""

        def _execute_child(self, args: Sequence[str], *how: Any) -> None:
            if list(args[:2]) != [sys.executable, "-m"]:
                super()._execute_child(args, *how)  # type: ignore[misc]
                return
            folder, environment, pipes = how[4], how[5], how[9:15]
            fds = [
                own if end == -1 else end
                for own, end in zip(_STANDARD_FDS, (pipes[0], pipes[3], pipes[5]), strict=True)
            ]
            request = pickle.dumps((args[2:], str(folder or Path.cwd()), dict(environment or os.environ)))
            with lock:
                socket.send_fds(client_end, [request], fds)
                self.pid = int(client_end.recv(32))
            self._child_created = True
            self._close_pipe_fds(*pipes)  # type: ignore[attr-defined]

    subprocess.Popen = ForkingPopen  # type: ignore[misc]


def _serve_forks(server: int, requests: socket.socket) -> NoReturn:
    """Fork one process for each order, until the server ends."""
    if not die_with_parent(server):
        _exit(0)
    while True:
        request, fds, _, _ = socket.recv_fds(requests, _MAX_REQUEST_BYTES, len(_STANDARD_FDS))
        if not request:
            _exit(0)
        intermediate = os.fork()
        if intermediate == 0:
            intermediate = os.getpid()
            child = os.fork()
            if child == 0:
                requests.close()
                _run_module(intermediate, fds, *pickle.loads(request))
            requests.send(str(child).encode())
            _exit(0)
        os.waitpid(intermediate, 0)
        for end in fds:
            os.close(end)


def _run_module(
    intermediate: int, fds: Sequence[int], command: Sequence[str], folder: str, environment: dict[str, str]
) -> NoReturn:
    """Behave like a process that was started with this command."""
    code = 1
    try:
        for own, end in zip(_STANDARD_FDS, fds, strict=True):
            os.dup2(end, own)
        for end in fds:
            os.close(end)
        os.environ.clear()
        os.environ.update(environment)
        os.chdir(folder)
        while os.getppid() == intermediate:  # the parent ends, and the server takes its place
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
        _exit(code)
