"""A scene as a complete file that loads nothing."""

from __future__ import annotations

import base64
import re

import pytest
import zstandard

from tests.app.inline_worker import run_jobs
from tests.app.scene3d.scene3d_client import Scene3dClient

MODES = ["volume", "prior", "drive"]


def make(api: Scene3dClient, **wanted: object) -> tuple[dict[str, object], str]:
    asked = api.call("POST", f"/api/runs/{api.run}/scenes", json=wanted)
    assert asked.status_code == 202, asked.text
    assert asked.json()["kind"] == "scene"
    run_jobs(api.server.server.context)
    view = api.call("GET", f"/api/outputs/{asked.json()['id']}").json()
    assert view["state"] == "complete", view["error"]
    file = api.call("GET", f"/api/outputs/{view['id']}/download")
    assert "attachment" in file.headers["content-disposition"]
    return view, file.content.decode()


@pytest.mark.parametrize("mode", MODES)
def test_a_scene_is_one_page_without_requests(api: Scene3dClient, mode: str) -> None:
    view, page = make(api, mode=mode, frame=20)
    assert view["name"] == f"drive_Run_1_{mode}.html"
    assert view["summary"]["mode"] == mode
    assert page.lstrip().lower().startswith("<!doctype html>")
    assert page.rstrip().endswith("</html>")
    plain = re.sub(r'<script.*?</script>|data:[^"]*', "", page, flags=re.DOTALL)
    assert "http" not in plain.replace("http-equiv", "")
    assert not re.search(r"<(script|link|img|iframe)[^>]*\b(src|href)=\"(?!data:|\")", page)
    assert "default-src 'none'" in page
    packed = re.search(r'__VISER_EMBED_DATA__="([^"]+)"', page)
    assert packed is not None
    content = base64.b64decode(packed[1])
    scene = zstandard.ZstdDecompressor().decompress(content[8:], max_output_size=int.from_bytes(content[:8], "little"))
    assert f"/{mode}/".encode() in scene
    assert re.search(rb"\xff\xd8\xff", scene), "the picture is in it"


def test_the_legend_and_the_name_are_on_the_page_as_text(api: Scene3dClient) -> None:
    view, page = make(api, mode="drive", frame=20, name="A & <b>", view=90)
    assert view["name"] == "A_b.html"
    assert "the camera sees 90°" in page
    assert "Metric drive" in page


@pytest.mark.parametrize(
    "wanted", [{"mode": "4d"}, {"frame": -1}, {"view": 5}, {"size": 9}, {"stretch": -1}, {"colour": "red"}, {"more": 1}]
)
def test_an_impossible_scene_is_refused(api: Scene3dClient, wanted: dict[str, object]) -> None:
    assert api.call("POST", f"/api/runs/{api.run}/scenes", json=wanted).status_code == 422


def test_an_unknown_run_has_no_scene(api: Scene3dClient) -> None:
    assert api.call("POST", f"/api/runs/{'0' * 32}/scenes", json={}).status_code == 404
