"""URLs and names of version 0.2 work like the present ones, and announce their removal."""

from __future__ import annotations

from app.api.old_addresses import DEPRECATED_SINCE, router
from sample_videos import SHIPPED
from tests.app.exchange.exchange_client import ExchangeClient


def test_outputs_under_former_urls(api: ExchangeClient) -> None:
    made = api.export()
    client = api.server.client
    listed = client.get("/api/artefacts?kind=export")
    assert listed.json()["artefacts"] == api.get("/api/outputs?kind=export")["outputs"]
    assert listed.headers["deprecation"] == DEPRECATED_SINCE
    assert listed.headers["link"] == '</api/outputs>; rel="successor-version"'
    one = client.get(f"/api/artefacts/{made['id']}")
    assert one.json() == api.get(f"/api/outputs/{made['id']}")
    file = client.get(f"/api/artefacts/{made['id']}/download")
    assert (file.content, file.headers["deprecation"]) == (api.download(made), DEPRECATED_SINCE)
    assert file.headers["link"] == f'</api/outputs/{made["id"]}/download>; rel="successor-version"'
    assert client.post(f"/api/artefacts/{made['id']}/cancel").status_code == 202
    assert client.delete(f"/api/artefacts/{made['id']}").status_code == 204
    assert client.get(f"/api/outputs/{made['id']}").status_code == 404
    assert client.get("/api/artefacts?kind=nothing").status_code == 422


def test_ground_truth_under_former_urls(api: ExchangeClient) -> None:
    client, video = api.server.client, api.video_id
    rows = SHIPPED[0].truth.read_bytes().splitlines(keepends=True)[:2]
    put = client.put(f"/api/videos/{video}/truths/mine", content=b"".join(rows), headers={"Content-Type": "text/csv"})
    assert put.status_code == 201, put.text
    listed = client.get(f"/api/videos/{video}/truths")
    assert listed.json()["truths"] == api.get(f"/api/videos/{video}/ground-truths")["ground_truths"]
    assert listed.headers["link"] == f'</api/videos/{video}/ground-truths>; rel="successor-version"'
    path = f"truths/{put.json()['id']}"
    boxes = client.get(f"/api/{path}/boxes?first=0&last=74").json()
    assert boxes == api.get(f"/api/ground-{path}/boxes?first=0&last=74")
    assert client.delete(f"/api/{path}").status_code == 204
    assert api.get(f"/api/videos/{video}/ground-truths")["ground_truths"] == []


def test_3d_views_under_former_urls(api: ExchangeClient) -> None:
    client = api.server.client
    found = client.get(f"/api/runs/{api.run_id}/space?view={'ab' * 8}")
    assert found.json() == api.get(f"/api/runs/{api.run_id}/scene3d?view={'ab' * 8}")
    moved = client.post(f"/api/runs/{api.run_id}/space/cursor", json={"frame": 3})
    assert (moved.status_code, moved.json()) == (200, {"views": 0})
    assert moved.headers["link"] == f'</api/runs/{api.run_id}/scene3d/cursor>; rel="successor-version"'


def test_a_preview_under_its_former_name(api: ExchangeClient) -> None:
    address = f"/api/videos/{api.video_id}/frames/3"
    assert api.server.client.get(f"{address}?glance=true").headers["deprecation"] == DEPRECATED_SINCE
    for query in ("", "?preview=true"):
        assert "deprecation" not in api.server.client.get(address + query).headers


def test_uncertainty_under_its_former_name(api: ExchangeClient) -> None:
    tracks = api.get(f"/api/runs/{api.run_id}/tracks")
    assert tracks["doubt"] == tracks["uncertainty"]
    assert tracks["uncertainty"]


def test_former_urls_are_not_in_the_schema(read_only_api: ExchangeClient) -> None:
    former = {route.path for route in router.routes}  # type: ignore[attr-defined]
    assert len(former) > 5
    assert not former & read_only_api.get("/api/openapi.json")["paths"].keys()
