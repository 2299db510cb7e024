"""Numba says whether kernels are being compiled, also in forked processes, and only if its cache lacks them."""

from __future__ import annotations

import importlib.util
import io
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import pytest
from numba.core.event import Listener, install_listener

from tests.waiting import wait_until
from tsr_engine import compilation
from tsr_engine.cli import progress
from tsr_engine.cli.progress import progress_bar
from tsr_engine.compilation import COMPILING, watch_compilation


class CompilationListener(Listener):  # type: ignore[misc] # numba has no types
    """Calls a function at the start of each compilation."""

    def __init__(self, do: Callable[[], None]) -> None:
        self._do = do

    def on_start(self, _event: Any) -> None:
        self._do()

    def on_end(self, _event: Any) -> None:
        pass


def in_forked_process(do: Callable[[], object]) -> int:
    """Call a function in a forked process, and return the status with which that ended."""
    child = os.fork()
    if child == 0:
        try:
            do()
        finally:
            os._exit(0)
    return os.waitpid(child, 0)[1]


def new_kernel() -> Any:
    """A kernel that no cache has."""
    return numba.njit(lambda x: x + 1)


def test_a_compilation_is_seen_while_it_lasts_and_a_moment_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    kernel, seen = new_kernel(), []
    monkeypatch.setattr(compilation, "NEXT_KERNEL_S", 0.0)
    with (
        watch_compilation() as note_now,
        install_listener("numba:compile", CompilationListener(lambda: seen.append(note_now()))),
    ):
        assert not note_now()
        kernel(1)
        assert (seen, note_now()) == ([COMPILING], "")
        kernel(2)
        assert seen == [COMPILING], "it is compiled by now"
        monkeypatch.setattr(compilation, "NEXT_KERNEL_S", 60.0)
        kernel(1.5)
        assert note_now(), "the next kernel may follow"
    new_kernel()(1)
    assert seen == [COMPILING, COMPILING], "the block has ended"


def test_a_kernel_that_is_called_by_another_does_not_end_the_compilation(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compilation, "NEXT_KERNEL_S", 0.0)
    inner = new_kernel()
    outer, seen = numba.njit(lambda x: inner(x) + 1), []
    with watch_compilation() as note_now:

        class After(CompilationListener):
            def on_end(self, _event: Any) -> None:
                seen.append(note_now())

        with install_listener("numba:compile", After(lambda: None)):
            outer(1)
    assert seen == [COMPILING, ""]


def test_a_kernel_in_the_cache_is_not_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = tmp_path / "cached_kernel.py"
    source.write_text("import numba\n\n\n@numba.njit(cache=True)\ndef kernel(x):\n    return x + 1\n")
    monkeypatch.setattr(compilation, "NEXT_KERNEL_S", 60.0)

    def note() -> str:
        spec = importlib.util.spec_from_file_location("cached_kernel", source)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, "cached_kernel", module)
        spec.loader.exec_module(module)
        with watch_compilation() as note_now:
            assert module.kernel(1) == 2
            return note_now()

    assert [note(), note()] == [COMPILING, ""]


def test_a_forked_process_that_compiles_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compilation, "NEXT_KERNEL_S", 60.0)
    kernel = new_kernel()
    with watch_compilation() as note_now:
        in_forked_process(lambda: kernel(1))
        assert note_now()
        assert kernel.signatures == [], "this process has compiled nothing"


def test_a_process_that_dies_while_it_compiles_is_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compilation, "MAX_SILENCE_S", 3.0)
    kernel = new_kernel()
    with watch_compilation() as note_now:
        with install_listener("numba:compile", CompilationListener(lambda: os.kill(os.getpid(), signal.SIGKILL))):
            assert in_forked_process(lambda: kernel(1)) == signal.SIGKILL
        wait_until(lambda: not note_now(), 60)


def test_a_kernel_may_take_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compilation, "MAX_SILENCE_S", 1.0)
    monkeypatch.setattr(compilation, "WORD_INTERVAL_S", 0.01)
    seen: list[str] = []

    def take_long() -> None:
        time.sleep(2.0)
        seen.append(note_now())

    with watch_compilation() as note_now, install_listener("numba:compile", CompilationListener(take_long)):
        new_kernel()(1)
    assert seen == [COMPILING]


class Terminal(io.StringIO):
    """A standard error that is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("compiles", [True, False])
def test_a_progress_bar_says_that_kernels_are_compiled(compiles: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(compilation, "NEXT_KERNEL_S", 60.0)
    kernel = new_kernel()
    if not compiles:
        kernel(1)
    with progress_bar("tracking", "frames") as show:
        kernel(1)
        show(1, 3, "")
    assert "tracking" in terminal.getvalue()
    assert (COMPILING in terminal.getvalue()) == compiles


@pytest.mark.parametrize("compiles", [True, False])
def test_without_a_terminal_one_line_says_that_kernels_are_compiled(
    compiles: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    messages: list[str] = []
    monkeypatch.setattr(progress, "say", messages.append)
    monkeypatch.setattr(progress, "_POLL_INTERVAL_S", 0.01)
    kernel = new_kernel()
    if not compiles:
        kernel(1)
    with progress_bar("tracking", "frames") as show:
        monkeypatch.setattr(compilation, "NEXT_KERNEL_S", 0.2)
        kernel(1)
        if compiles:
            wait_until(lambda: messages)
            time.sleep(0.4)  # the compilation is over
            kernel(1.5)
        time.sleep(0.1)
        show(1, 3, "")
    assert messages == ([f"{COMPILING.capitalize()}."] if compiles else [])
