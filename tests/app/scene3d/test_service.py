"""Views are opened, moved and closed by many threads, here with stand-ins that draw nothing."""

from __future__ import annotations

import gc
import threading
import time
import weakref
from collections.abc import Iterator
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import pytest

from app.errors import Busy
from app.scene3d import service as service_module
from app.scene3d.service import Scene3dService
from tests.waiting import wait_until


class FakeView:
    """A view that refers to itself, as viser's objects do."""

    def __init__(self) -> None:
        self.clients, self.left_at, self.itself = 0, time.monotonic(), self
        self.state: dict[str, object] = {}

    def request(self, **changes: object) -> None:
        self.state |= changes

    def stop(self) -> None:
        self.state["stopped"] = True


@pytest.fixture
def service(monkeypatch: pytest.MonkeyPatch) -> Iterator[Scene3dService]:
    nothing: Any = SimpleNamespace(raw=None, read=lambda: nullcontext(SimpleNamespace(get=lambda *_: None)))
    monkeypatch.setattr(service_module, "marked_tracks", lambda *_: frozenset())
    monkeypatch.setattr(service_module, "load_scene3d", lambda *_: SimpleNamespace(frames=(), times=(), ids=()))
    monkeypatch.setattr(service_module, "View", lambda *_: FakeView())
    service = Scene3dService(nothing, nothing, nothing, nothing, nothing)
    yield service
    service.close()


def test_a_view_is_opened_once_after_a_failure_too(service: Scene3dService, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first opening fails while a second caller waits; a third one comes while the second one opens the view."""
    turns, opened = [threading.Event(), threading.Event(), threading.Event()], []

    def open_view(*_: object) -> FakeView:
        number = len(opened)
        opened.append(number)
        assert turns[number].wait(60)
        if number == 0:
            raise ValueError("no such run")
        return FakeView()

    monkeypatch.setattr(service_module, "View", open_view)
    found: list[Any] = []

    def connect() -> None:
        try:
            found.append(service.connect("run", "view"))
        except ValueError:
            found.append(FakeView())

    threads = [threading.Thread(target=connect) for _ in range(3)]
    threads[0].start()
    wait_until(lambda: len(opened) == 1)
    threads[1].start()
    time.sleep(0.2)  # it waits for the first one
    turns[0].set()
    wait_until(lambda: len(opened) == 2)
    threads[2].start()
    time.sleep(0.2)
    turns[1].set()
    turns[2].set()
    for thread in threads:
        thread.join(60)
    assert len(opened) == 2
    assert found[1] is found[2] is service.views()["run", "view"]
    assert found[1].clients == 2


def test_views_that_are_opened_at_once_keep_the_limit(service: Scene3dService, monkeypatch: pytest.MonkeyPatch) -> None:
    for number in range(service_module.MAX_VIEWS - 1):
        service.connect("run", str(number))
    begun, turn = threading.Event(), threading.Event()

    def open_view(*_: object) -> FakeView:
        begun.set()
        assert turn.wait(60)
        return FakeView()

    monkeypatch.setattr(service_module, "View", open_view)
    first = threading.Thread(target=service.connect, args=("run", "first"))
    first.start()
    assert begun.wait(60)
    monkeypatch.setattr(service_module, "View", lambda *_: FakeView())
    with pytest.raises(Busy, match="which is the limit"):
        service.connect("run", "second")
    turn.set()
    first.join(60)
    assert len(service.views()) == service_module.MAX_VIEWS


def test_a_move_while_a_view_is_registered_wins_over_an_earlier_one(
    service: Scene3dService, monkeypatch: pytest.MonkeyPatch
) -> None:
    class SlowView(FakeView):
        def request(self, **changes: object) -> None:
            if "frame" in changes and not self.state:
                self.state["asked"] = True
                move.start()
                move.join(0.3)
            super().request(**changes)

    move = threading.Thread(target=lambda: service.move("run", "view", frame=2))
    monkeypatch.setattr(service_module, "View", lambda *_: SlowView())
    service.move("run", "view", frame=1)
    view: Any = service.connect("run", "view")
    move.join(60)
    assert view.state["frame"] == 2


@pytest.mark.parametrize("by", ["room", "removal"])
def test_a_view_that_is_closed_for_any_reason_leaves_the_memory(service: Scene3dService, by: str) -> None:
    view = service.connect("run", "0")
    service.disconnect(view)
    kept = weakref.ref(view)
    del view
    gc.disable()  # as in a large process, which collects old objects seldom
    try:
        if by == "removal":
            service.forget("run")
        else:
            for number in range(service_module.MAX_VIEWS):
                service.connect("run", str(number + 1))
        assert ("run", "0") not in service.views()
        service.stop_idle()
        assert kept() is None
    finally:
        gc.enable()
