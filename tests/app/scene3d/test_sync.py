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
from tests.app.scene3d.scene3d_client import (
    MAX_WAIT_S,
    Scene3dClient,
    read_all_until,
    read_until,
    send_camera,
    send_message,
)
from tests.waiting import wait_until


def events(api: Scene3dClient) -> list[dict[str, Any]]:
    with api.server.server.context.database.read() as session:
        return [event.data for event in session.scalars(select(Event).where(Event.kind == "space").order_by(Event.seq))]


def opened(api: Scene3dClient, name: str) -> ClientConnection:
    line = api.socket(name)
    send_camera(line)
    read_until(line, b"/volume/beads")
    return line


def test_the_url_of_a_view_is_returned_without_starting_it(api: Scene3dClient) -> None:
    before = len(api.scene3d.views())
    answer = api.call("GET", f"/api/runs/{api.run}/scene3d").json()
    assert answer["url"] == f"/viser/{api.run}/{answer['view']}"
    assert [mode["id"] for mode in answer["modes"]] == ["volume", "prior", "drive"]
    assert len(api.scene3d.views()) == before
    named = api.call("GET", f"/api/runs/{api.run}/scene3d", params={"view": "ab" * 8}).json()
    assert named["view"] == "ab" * 8
    assert api.call("GET", f"/api/runs/{'0' * 32}/scene3d").status_code == 404


def test_the_cursor_moves_the_plane_and_the_last_position_wins(api: Scene3dClient) -> None:
    name = api.name()
    with opened(api, name) as line:
        for frame in range(5, 45):  # as fast as a user on a fast machine
            assert api.scene3d.move(api.run, name, frame=frame) == 1
        answer = api.call("POST", f"/api/runs/{api.run}/scene3d/cursor", json={"frame": 45, "view": name})
        assert answer.json() == {"views": 1}
        drawn = [text for text in read_all_until(line, "frame 45 ·".encode()) if b"frame " in text]
        assert len(drawn) < 30, "most of a dragged cursor is never drawn"


def test_a_click_is_sent_to_the_page_and_selects(api: Scene3dClient) -> None:
    name = api.name()
    with opened(api, name) as line:
        view = api.scene3d.views()[api.run, name]
        assert view.wait(MAX_WAIT_S)
        node = view.scene.blocks.name
        before = len(events(api))
        send_message(
            line, "SceneNodeClickMessage", name=node, instance_index=0, ray_origin=(0.0, 0.0, 0.0),
            ray_direction=(0.0, 1.0, 0.0), screen_pos=(0.5, 0.5), modifier=None, owner=view.host.server.scene._owner_id,
        )  # fmt: skip
        reported = wait_until(lambda: events(api)[before:])
        assert reported[0]["run"] == api.run
        assert reported[0]["view"] == name
        tracks = api.call("GET", f"/api/runs/{api.run}/tracks").json()["id"]
        assert reported[0]["track"] in {f"m{track}" for track in tracks}
        key = reported[0]["track"]
        assert read_until(line, f" · #{key[1:]}".encode())
        assert view.view_state.frame == reported[0]["frame"]


def test_a_selection_of_the_page_is_shown(api: Scene3dClient) -> None:
    name = api.name()
    track = api.call("GET", f"/api/runs/{api.run}/tracks").json()["id"][0]
    with opened(api, name) as line:
        body = {"frame": 20, "track": f"m{track}", "view": name}
        api.call("POST", f"/api/runs/{api.run}/scene3d/cursor", json=body)
        assert read_until(line, f" · #{track}".encode())


@pytest.mark.parametrize(("mode", "node"), [("prior", b"/prior/cloth"), ("drive", b"/drive/camera")])
def test_the_page_chooses_the_mode(api: Scene3dClient, mode: str, node: bytes) -> None:
    name = api.name()
    with opened(api, name) as line:
        api.call("POST", f"/api/runs/{api.run}/scene3d/cursor", json={"frame": 20, "view": name, "mode": mode})
        assert read_until(line, node)


def test_a_mode_chosen_in_viser_is_sent_to_the_page(api: Scene3dClient) -> None:
    name = api.name()
    with opened(api, name) as line:
        view = api.scene3d.views()[api.run, name]
        before = len(events(api))
        uuid = view.gui.mode._impl.uuid
        send_message(line, "GuiUpdateMessage", uuid=uuid, updates={"value": "Metric drive"})
        reported = wait_until(lambda: events(api)[before:])
        assert reported == [{"run": api.run, "view": name, "mode": "drive"}]
        assert read_until(line, b"/drive/camera")


def test_the_start_of_a_view_can_be_set_before_it_is_open(api: Scene3dClient) -> None:
    name = api.name()
    answer = api.call("POST", f"/api/runs/{api.run}/scene3d/cursor", json={"frame": 33, "view": name})
    assert answer.json() == {"views": 0}
    with api.socket(name) as line:
        send_camera(line)
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
def test_an_invalid_cursor_is_refused(api: Scene3dClient, body: dict[str, Any]) -> None:
    answer = api.call("POST", f"/api/runs/{api.run}/scene3d/cursor", json=body)
    assert answer.status_code == 422, json.dumps(body)


def test_an_unknown_frame_or_track_is_ignored(api: Scene3dClient) -> None:
    name = api.name()
    with opened(api, name) as line:
        for body in ({"frame": 2**31 - 1, "view": name, "track": "m999"}, {"frame": 3, "view": name, "track": "h12ab"}):
            assert api.call("POST", f"/api/runs/{api.run}/scene3d/cursor", json=body).status_code == 200
        assert read_until(line, "frame 3 ·".encode())


def test_a_closed_view_leaves_nothing_in_memory(api: Scene3dClient, monkeypatch: pytest.MonkeyPatch) -> None:
    before = set(api.scene3d.views())
    view = api.scene3d.connect(api.run, api.name())
    assert view.wait(MAX_WAIT_S)
    api.scene3d.disconnect(view)
    kept = weakref.ref(view)
    del view
    gc.disable()  # as in a large process, which collects old objects seldom
    try:
        monkeypatch.setattr(api.scene3d, "idle", 0.0)
        api.scene3d.stop_idle()
        assert set(api.scene3d.views()) <= before

        def gone() -> bool:
            api.scene3d.stop_idle()  # threads of the view may have kept it until now
            return kept() is None

        wait_until(gone)
    finally:
        gc.enable()
