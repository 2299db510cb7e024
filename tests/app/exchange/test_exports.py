"""Exports over HTTP: requested, refused, made in the background, downloaded completely or partly, listed."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.outputs.folders import output_folder
from app.storage.models import Run, Video
from tests.app.exchange.exchange_client import ExchangeClient, manifest_of, unzipped
from tsr_engine.bundle.evidence_slice import write_slice
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.exchange.registry import FORMATS
from tsr_engine.io.video_writer import VideoWriter


def test_the_formats_are_listed_with_their_options(read_only_api: ExchangeClient) -> None:
    found = {each["name"]: each for each in read_only_api.get("/api/formats")["formats"]}
    assert list(found) == list(FORMATS)
    cvat = found["cvat-video"]
    assert cvat["can_export"]
    assert cvat["can_import"]
    assert not cvat["needs_pictures"]
    assert found["gtsrb"]["needs_pictures"]
    assert ("task", True) in [(one["name"], one["free"]) for one in found["label-studio"]["import_switches"]]
    assert not any(one["free"] for one in cvat["export_switches"])
    assert [found[name]["key_frames"] for name in ("cvat-video", "tracks-csv")] == [True, False]


def test_an_export_is_one_complete_file(api: ExchangeClient) -> None:
    api.make_corrections()
    output = api.export(name="my signs")
    assert (output["state"], output["kind"], output["run_id"]) == ("complete", "export", api.run_id)
    assert output["name"] == "my signs.zip"
    counts = output["summary"]["counts"]
    assert (counts["tracks"], counts["negatives"]) == (2, 1), "the rejected one is no sign"
    assert output["summary"]["skipped_count"] == 0
    content = api.download(output)
    assert len(content) == output["size"]
    manifest = manifest_of(content)
    video = manifest["videos"][0]
    assert video["sha256"] == api.video_id
    assert video["provenance"]["edit_revision"] == 9
    assert video["provenance"]["run"]["id"] == api.run_id
    assert video["provenance"]["parameters"]["gate"]["tau"] > 0
    assert [entry["id"] for entry in video["negatives"]] == ["m2"]
    assert b">m2<" not in unzipped(content)["annotations.xml"]
    assert manifest["asked"]["format"] == "cvat-video"
    assert [path.name for path in api.output_files()] == [output["id"], "export.zip"]


def test_ranges_of_the_file_are_consistent(read_only_api: ExchangeClient) -> None:
    api = read_only_api
    output = api.export()
    whole = api.download(output)
    url = f"/api/outputs/{output['id']}/download"
    answer = api.server.client.get(url, headers={"Range": "bytes=10-29", "Accept-Encoding": "gzip"})
    assert (answer.status_code, answer.content) == (206, whole[10:30])
    assert answer.headers["content-range"] == f"bytes 10-29/{len(whole)}"
    assert "attachment" in answer.headers["content-disposition"]
    assert answer.headers["content-type"] == "application/octet-stream"


def test_filters_and_options_reach_the_file(api: ExchangeClient) -> None:
    api.make_corrections()
    rejected = api.export(states=["rejected"])
    counts = rejected["summary"]["counts"]
    assert (counts["tracks"], counts["negatives"]) == (0, 1)
    without = api.export(states=["open", "accepted", "needs_work"])
    assert "rejected" in manifest_of(api.download(without))["skipped"][0]["reason"]
    drawn = api.export(classes=[1])
    assert b"hdrawn01" in unzipped(api.download(drawn))["annotations.xml"]
    assert b"m1" not in unzipped(api.download(drawn))["annotations.xml"]
    part = api.export(first=5, stop=8)
    assert part["summary"]["counts"]["boxes"] <= 3 * 3


def test_pictures_and_split_are_exported(read_only_api: ExchangeClient) -> None:
    api = read_only_api
    output = api.export(format="yolo", pictures="annotated", split={"train": 1.0, "val": 0.0}, stop=40)
    assert output["state"] == "complete", output["error"]
    names = unzipped(api.download(output))
    assert any(name.endswith(".jpg") for name in names)
    assert output["summary"]["split"]["rule"] == "sign"
    assert output["summary"]["split"]["tracks"] == {"train": output["summary"]["counts"]["tracks"]}
    crops = api.export(format="gtsrb", pictures="annotated", stop=40)
    assert crops["state"] == "complete", crops["error"]
    assert crops["summary"]["split"]["tracks"] == {}


def test_boxes_outside_the_range_of_the_run_are_counted(api: ExchangeClient) -> None:
    """A run of the first 40 frames; a person has drawn boxes after them."""
    with EvidenceReader(api.home / "runs" / api.run_id) as reader:
        header = reader.header
        part = reader.folder.with_name("1" * 32)
        write_slice(reader, part, 0, 40, header)
    with api.server.context.database.write() as session:
        session.get_one(Run, api.run_id).folder = f"runs/{part.name}"
    whole = api.export(format="tracks-csv")
    assert whole["summary"]["skipped"] == []
    drawn = {"key": "hdrawn01", "class_id": 1, "box": [20.0, 30.0, 44.0, 52.0]}
    api.edit({"name": "create_track", **drawn, "frame": 36}, {})
    api.edit({"name": "set_box", "key": "hdrawn01", "frame": 50, "box": [22.0, 30.0, 46.0, 52.0]}, {"hdrawn01": 1})
    api.edit({"name": "create_track", **drawn, "key": "hdrawn02", "frame": 60}, {})
    api.edit({"name": "create_track", **drawn, "key": "hdrawn03", "frame": 20}, {})
    api.edit({"name": "create_track", **drawn, "key": "hdrawn04", "frame": 70}, {})
    api.edit({"name": "delete_track", "key": "hdrawn04", "frame": 70}, {"hdrawn04": 1})
    output = api.export(format="tracks-csv")
    (reported,) = output["summary"]["skipped"]
    assert reported["what"] == "drive.mp4: 12 boxes of 2 tracks"
    assert reported["reason"].startswith("They lie outside of frames 0 to 39, the only ones that the run has tracked.")
    assert output["summary"]["counts"]["boxes"] == whole["summary"]["counts"]["boxes"] + 4 + 1


@pytest.mark.parametrize("format", ["mot", "gtsrb"])
def test_pictures_of_a_replaced_video_are_not_exported(api: ExchangeClient, tmp_path: Path, format: str) -> None:
    with api.server.context.database.read() as session:
        video_path = Path(session.get_one(Video, api.video_id).path)
    other = tmp_path / "another" / "drive.mp4"
    other.parent.mkdir()
    with VideoWriter(other, 128, 96, Fraction(25)) as writer:
        for k in range(75):
            writer.write(np.full((96, 128, 3), 3 * k, np.uint8))
    with api.server.context.database.write() as session:
        session.get_one(Video, api.video_id).path = str(other)
    output = api.export(format=format, pictures="annotated", stop=40)
    assert output["state"] == "failed"
    assert f"{other} is not the video of the run" in output["error"]
    assert api.output_files() == []
    assert api.export(format="mot", stop=40)["state"] == "complete", "boxes need no file"
    other.write_bytes(video_path.read_bytes())
    assert api.export(format=format, pictures="annotated", stop=40)["state"] == "complete", "a copy is the video"


def test_counts_of_a_split_are_of_signs_only(api: ExchangeClient) -> None:
    """``correct`` rejects one track and draws another. False positives are split too, but not counted."""
    request: dict[str, Any] = {"states": ["open", "accepted", "rejected"], "format": "gtsrb", "pictures": "annotated"}
    output = api.export(**request, split={"train": 1, "val": 0, "test": 1}, split_by="sign")
    assert output["state"] == "complete", output["error"]
    summary = output["summary"]
    assert sum(summary["split"]["tracks"].values()) == summary["counts"]["tracks"] > 1
    assert list(summary["split"]["tracks"]) == ["train", "test"]


@pytest.mark.parametrize(
    ("request_", "status", "words"),
    [
        ({"format": "papyrus"}, 422, "There is no format 'papyrus'"),
        ({"runs": ["0" * 32]}, 404, "There is no run"),
        ({"runs": []}, 422, "runs"),
        ({"format": "gtsrb"}, 422, "Export with pictures"),
        ({"switches": {"colour": "red"}}, 422, "no option 'colour'"),
        ({"first": 9, "stop": 9}, 422, "first < stop"),
        ({"split": {"train": 0, "val": 0, "test": 0}}, 422, "all 0"),
        ({"name": "../../etc/passwd"}, 422, "name"),
        ({"states": ["best"]}, 422, "states"),
        ({"thin_px": -1}, 422, "thin_px"),
    ],
)
def test_impossible_exports_are_refused_at_once(
    read_only_api: ExchangeClient, request_: Any, status: int, words: str
) -> None:
    api = read_only_api
    before = api.get("/api/outputs")["outputs"]
    request = {"runs": [api.run_id], "format": "cvat-video", **request_}
    answer = api.server.client.post("/api/exports", json=request)
    assert answer.status_code == status, answer.text
    assert words in answer.json()["error"]["message"]
    assert api.get("/api/outputs")["outputs"] == before


def test_two_runs_of_one_video_are_refused(read_only_api: ExchangeClient) -> None:
    api = read_only_api
    answer = api.server.client.post("/api/exports", json={"runs": [api.run_id, api.run_id], "format": "cvat-video"})
    assert answer.status_code == 422
    assert "one run per video" in answer.json()["error"]["message"]


def test_lists_are_by_kind_and_run(api: ExchangeClient) -> None:
    first, second = api.export()["id"], api.export()["id"]
    found = [output["id"] for output in api.get("/api/outputs?kind=export")["outputs"]]
    assert set(found) == {first, second}
    assert api.get("/api/outputs?kind=scene")["outputs"] == []
    assert len(api.get(f"/api/outputs?run={api.run_id}")["outputs"]) == 2
    assert api.get(f"/api/outputs?run={'0' * 32}")["outputs"] == []


def test_exports_outlive_their_run(api: ExchangeClient) -> None:
    output = api.export()
    assert api.server.client.delete(f"/api/runs/{api.run_id}").status_code == 204
    assert api.get(f"/api/outputs/{output['id']}")["run_id"] is None
    assert unzipped(api.download(output))
    late = api.server.client.post("/api/exports", json={"runs": [api.run_id], "format": "cvat-video"})
    assert late.status_code == 404


def test_pages_receive_an_event_for_each_step(api: ExchangeClient) -> None:
    api.export()
    with api.server.context.database.read() as session:
        events = api.server.context.events.after(session, 0)
    states = [event.data["state"] for event in events if event.kind == "artefact"]
    assert states[0] == "queued"
    assert states[-1] == "complete"
    assert "running" in states


def test_a_missing_file_is_reported(api: ExchangeClient) -> None:
    output = api.export()
    (output_folder(api.home, output["id"]) / "export.zip").unlink()
    answer = api.server.client.get(f"/api/outputs/{output['id']}/download")
    assert answer.status_code == 404
    assert "Make it again" in answer.json()["error"]["message"]
