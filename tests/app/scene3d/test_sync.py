"""Review screen and 3-D view follow each other."""

from __future__ import annotations

import gc
import json
import weakref
from typing import Any

import pytest
from sqlalchemy import select
from websockets.sync.client import ClientConnection

from app.storage.models import Event
from tests.app.scene3d.scene3d_desk import PATIENCE, Desk, look, read_all_until, read_until, say, until


def events(desk: Desk) -> list[dict[str, Any]]:
    with desk.live.server.context.database.read() as session:
        return [event.data for event in session.scalars(select(Event).where(Event.kind == "space").order_by(Event.seq))]


def opened(desk: Desk, name: str) -> ClientConnection:
    line = desk.socket(name)
    look(line)
    read_until(line, b"/volume/beads")
    return line


def test_the_url_of_a_view_is_returned_without_starting_it(desk: Desk) -> None:
    before = len(desk.scene3d.views())
    answer = desk.call("GET", f"/api/runs/{desk.run}/scene3d").json()
    assert answer["url"] == f"/viser/{desk.run}/{answer['view']}"
    assert [mode["id"] for mode in answer["modes"]] == ["volume", "prior", "drive"]
    assert len(desk.scene3d.views()) == before
    named = desk.call("GET", f"/api/runs/{desk.run}/scene3d", params={"view": "ab" * 8}).json()
    assert named["view"] == "ab" * 8
    assert desk.call("GET", f"/api/runs/{'0' * 32}/scene3d").status_code == 404


def test_the_cursor_moves_the_plane_and_the_last_position_wins(desk: Desk) -> None:
    name = desk.name()
    with opened(desk, name) as line:
        for frame in range(5, 45):  # as fast as a user on a fast machine
            assert desk.scene3d.move(desk.run, name, frame=frame) == 1
        answer = desk.call("POST", f"/api/runs/{desk.run}/scene3d/cursor", json={"frame": 45, "view": name})
        assert answer.json() == {"views": 1}
        drawn = [text for text in read_all_until(line, "frame 45 ·".encode()) if b"frame " in text]
        assert len(drawn) < 30, "most of a dragged cursor is never drawn"


def test_a_click_is_sent_to_the_page_and_selects(desk: Desk) -> None:
    name = desk.name()
    with opened(desk, name) as line:
        view = desk.scene3d.views()[desk.run, name]
        assert view.wait(PATIENCE)
        node = view.scene.blocks.name
        before = len(events(desk))
        say(
            line, "SceneNodeClickMessage", name=node, instance_index=0, ray_origin=(0.0, 0.0, 0.0),
            ray_direction=(0.0, 1.0, 0.0), screen_pos=(0.5, 0.5), modifier=None, owner=view.host.server.scene._owner_id,
        )  # fmt: skip
        reported = until(lambda: events(desk)[before:])
        assert reported[0]["run"] == desk.run
        assert reported[0]["view"] == name
        tracks = desk.call("GET", f"/api/runs/{desk.run}/tracks").json()["id"]
        assert reported[0]["track"] in {f"m{track}" for track in tracks}
        key = reported[0]["track"]
        assert read_until(line, f" · #{key[1:]}".encode())
        assert view.view_state.frame == reported[0]["frame"]


def test_a_selection_of_the_page_is_shown(desk: Desk) -> None:
    name = desk.name()
    track = desk.call("GET", f"/api/runs/{desk.run}/tracks").json()["id"][0]
    with opened(desk, name) as line:
        body = {"frame": 20, "track": f"m{track}", "view": name}
        desk.call("POST", f"/api/runs/{desk.run}/scene3d/cursor", json=body)
        assert read_until(line, f" · #{track}".encode())


@pytest.mark.parametrize(("mode", "node"), [("prior", b"/prior/cloth"), ("drive", b"/drive/camera")])
def test_the_page_chooses_the_mode(desk: Desk, mode: str, node: bytes) -> None:
    name = desk.name()
    with opened(desk, name) as line:
        desk.call("POST", f"/api/runs/{desk.run}/scene3d/cursor", json={"frame": 20, "view": name, "mode": mode})
        assert read_until(line, node)


def test_a_mode_chosen_in_viser_is_sent_to_the_page(desk: Desk) -> None:
    name = desk.name()
    with opened(desk, name) as line:
        view = desk.scene3d.views()[desk.run, name]
        before = len(events(desk))
        uuid = view.gui.mode._impl.uuid
        say(line, "GuiUpdateMessage", uuid=uuid, updates={"value": "Metric drive"})
        reported = until(lambda: events(desk)[before:])
        assert reported == [{"run": desk.run, "view": name, "mode": "drive"}]
        assert read_until(line, b"/drive/camera")


def test_the_start_of_a_view_can_be_set_before_it_is_open(desk: Desk) -> None:
    name = desk.name()
    answer = desk.call("POST", f"/api/runs/{desk.run}/scene3d/cursor", json={"frame": 33, "view": name})
    assert answer.json() == {"views": 0}
    with desk.socket(name) as line:
        look(line)
        assert read_until(line, "frame 33 ·".encode())


@pytest.mark.parametrize(
    "body",
    [
        {},
        {"frame": -1},
        {"frame": 1.5},
        {"frame": 1, "view": "../x"},
        {"frame": 1, "mode": "4d"},
        {"frame": 1, "track": ""},
    ],
)
def test_an_invalid_cursor_is_refused(desk: Desk, body: dict[str, Any]) -> None:
    answer = desk.call("POST", f"/api/runs/{desk.run}/scene3d/cursor", json=body)
    assert answer.status_code == 422, json.dumps(body)


def test_an_unknown_frame_or_track_is_ignored(desk: Desk) -> None:
    name = desk.name()
    with opened(desk, name) as line:
        for body in ({"frame": 2**31 - 1, "view": name, "track": "m999"}, {"frame": 3, "view": name, "track": "h12ab"}):
            assert desk.call("POST", f"/api/runs/{desk.run}/scene3d/cursor", json=body).status_code == 200
        assert read_until(line, "frame 3 ·".encode())


def test_a_closed_view_leaves_nothing_in_memory(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    before = set(desk.scene3d.views())
    view = desk.scene3d.connect(desk.run, desk.name())
    assert view.wait(PATIENCE)
    desk.scene3d.disconnect(view)
    kept = weakref.ref(view)
    del view
    gc.disable()  # as in a large process, which collects old objects seldom
    try:
        monkeypatch.setattr(desk.scene3d, "idle", 0.0)
        desk.scene3d.stop_idle()
        assert set(desk.scene3d.views()) <= before

        def gone() -> bool:
            desk.scene3d.stop_idle()  # threads of the view may have kept it until now
            return kept() is None

        until(gone)
    finally:
        gc.enable()
