"""Files with labels and attributes missing from the library: mapped, added, remembered, and exported again."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest
from sqlalchemy import select

from app.cli.main import run as tsr
from app.errors import Conflict
from app.exchange import imports as imports_module
from app.exchange.import_file import ImportFile
from app.exchange.imports import ImportResult
from app.storage.models import LabelWord
from tests.app.exchange.exchange_client import ALL_STATES, ExchangeClient
from tests.app.toy_home import ToyHome

BOX = '<box frame="{0}" keyframe="1" outside="{1}" occluded="0" xtl="20" ytl="10" xbr="50" ybr="40">{2}</box>'
LABELS = """<meta><task><labels>
<label><name>pedestrian_crossing</name><color>#1e90ff</color><attributes>
 <attribute><name>lit</name><mutable>True</mutable><input_type>checkbox</input_type><values>false</values></attribute>
 <attribute><name>side</name><mutable>False</mutable><input_type>select</input_type><values>left
right</values></attribute>
</attributes></label><label><name>yield</name></label></labels></task></meta>"""


def attribute_elements(lit: str) -> str:
    """Attributes of a box."""
    return f'<attribute name="lit">{lit}</attribute><attribute name="side">right</attribute>'


FOREIGN_FILE = (
    f'<annotations>{LABELS}<track id="0" label="pedestrian_crossing">'
    + BOX.format(1, 0, attribute_elements("true"))
    + BOX.format(4, 0, attribute_elements("false"))
    + BOX.format(8, 1, "")
    + '</track><track id="1" label="yield">'
    + BOX.format(20, 0, "")
    + BOX.format(24, 1, "")
    + "</track></annotations>"
).encode()


def labels_of(api: ExchangeClient) -> dict[str, Any]:
    """Labels of the library by key."""
    return {label["key"]: label for label in api.get("/api/labels")}


def test_a_file_with_known_similar_and_unknown_names(
    api: ExchangeClient, tracked_home: ToyHome, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`pedestrian_crossing` exists, and `yield` matches the set's give way."""
    file, out, home = tmp_path / "a.xml", tmp_path / "out.zip", ["--home", str(api.home)]
    file.write_bytes(FOREIGN_FILE)
    onto = ["import", str(file), "--onto", str(tracked_home.video), "--as", "run", *home]
    assert tsr(onto) == 2
    reported = capsys.readouterr().err
    assert "'pedestrian_crossing' (1 track, 2 boxes" in reported
    assert "--label NAME=KEY" in reported
    assert "--unknown add|skip|refuse" in reported
    assert "unknown=" not in reported
    assert "yield" not in reported
    assert tsr([*onto, "--unknown", "add", "--json"]) == 0
    run = json.loads(capsys.readouterr().out)
    assert any("'pedestrian_crossing' was added" in sentence for sentence in run["repaired"])
    states = ["--states", "open,accepted,needs_work"]
    assert tsr(["export", run["id"], "--format", "cvat-video", "--out", str(out), *states, *home]) == 0
    root = ET.fromstring(zipfile.ZipFile(out).read("annotations.xml"))
    assert [track.get("label") for track in root.iter("track")] == ["pedestrian_crossing", "give way"]
    boxes = [box for box in root.iter("box") if box.get("outside") == "0"]
    answers = [{each.get("name"): each.text for each in box.iter("attribute")} for box in boxes]
    assert [(each.get("lit"), each.get("side")) for each in answers[:5]] == [
        *[("true", "right")] * 3,
        *[("false", "right")] * 2,
    ]
    declared = {each.findtext("name"): each for each in root.iter("label")}["pedestrian_crossing"]
    assert declared.findtext("color") == "#1e90ff"
    kinds = {each.findtext("name"): each.findtext("input_type") for each in declared.iter("attribute")}
    assert (kinds["lit"], kinds["side"]) == ("checkbox", "select")


def test_unknown_names_are_listed_before_anything_is_stored(api: ExchangeClient) -> None:
    foreign_file = FOREIGN_FILE.replace(b"pedestrian_crossing", b"giveway sign")
    runs = api.get(f"/api/videos/{api.video_id}/runs")
    answer = api.send_import(foreign_file, "run", name="a.xml")
    assert answer.status_code == 422
    error = answer.json()["error"]
    assert error["code"] == "unknown_labels"
    assert "unknown=add" in error["message"]
    (name,) = error["details"]["labels"]
    assert (name["name"], name["tracks"], name["boxes"]) == ("giveway sign", 1, 2)
    assert name["suggestions"][0] == {"id": 13, "key": "give-way", "name": "give way"}
    assert name["similar"] is True
    assert name["example"] == {"frame": 1, "box": [20.0, 10.0, 50.0, 40.0]}
    assert api.get(f"/api/videos/{api.video_id}/runs") == runs
    assert len(labels_of(api)) == 43


def test_mappings_are_remembered_and_reported(api: ExchangeClient) -> None:
    first = api.import_file(
        FOREIGN_FILE, "run", name="a.xml", label_map=json.dumps({"pedestrian_crossing": "pedestrians", "yield": -1})
    )
    assert {track.label for track in api.tracks(first["id"]).values()} == {27, -1}
    again = api.import_file(FOREIGN_FILE, "truth", name="b.xml")
    assert "'pedestrian_crossing' was taken as 'pedestrians', the choice for an earlier file." in again["repaired"]
    assert "'yield' was taken as no label of the set, the choice for an earlier file." in again["repaired"]
    third = api.import_file(FOREIGN_FILE, "run", name="c.xml", label_map=json.dumps({"yield": 13}))
    assert {track.label for track in api.tracks(third["id"]).values()} == {27, 13}


def test_tracks_with_skipped_names_are_left_out(api: ExchangeClient) -> None:
    found = api.import_file(FOREIGN_FILE, "run", name="a.xml", unknown="skip")
    assert found["tracks"] == 1
    assert any("pedestrian_crossing" in item["what"] for item in found["skipped"])
    assert len(labels_of(api)) == 43


@pytest.mark.parametrize("kind", ["annotation", "truth"])
def test_labels_are_added_for_every_kind_of_import(api: ExchangeClient, kind: str) -> None:
    api.import_file(FOREIGN_FILE, kind, name="a.xml", unknown="add")
    added = labels_of(api)["pedestrian-crossing"]
    assert (added["id"], added["name"], added["colour"]) == (43, "pedestrian_crossing", "#1e90ff")
    assert {each["name"]: each["mutable"] for each in added["attributes"]} == {"lit": True, "side": False}
    history = api.get("/api/label-sets/gtsrb-43/history")
    assert "pedestrian_crossing" in json.dumps(history)
    again = api.import_file(FOREIGN_FILE, kind, name="b.xml")
    assert not any("added" in sentence for sentence in again["repaired"])
    assert len(labels_of(api)) == 44


def test_some_names_of_a_file_are_added_and_others_left_out(api: ExchangeClient) -> None:
    """Declarations of added names are imported too."""
    foreign_file = FOREIGN_FILE.replace(b'label="yield"', b'label="tree"')
    found = api.import_file(foreign_file, "run", name="a.xml", unknown="skip", add='["pedestrian_crossing"]')
    added = labels_of(api)["pedestrian-crossing"]
    assert (added["colour"], sorted(each["name"] for each in added["attributes"])) == ("#1e90ff", ["lit", "side"])
    assert found["tracks"] == 1
    assert any("'tree'" in item["what"] for item in found["skipped"])
    assert len(labels_of(api)) == 44
    answer = api.send_import(foreign_file, "run", name="a.xml", add='"tree"')
    assert answer.json()["error"]["message"].startswith("add must be a JSON list like")


@pytest.mark.parametrize("kind", ["annotation", "truth", "run"])
def test_labels_mappings_and_tracks_are_stored_together_or_not_at_all(
    api: ExchangeClient, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    context = api.server.context
    before = api.get("/api/label-sets/gtsrb-43/history")
    with monkeypatch.context() as patch:
        patch.setattr(type(context.bulk_edits), "record", fail)
        patch.setattr("app.ground_truths.service.pack", fail)
        patch.setattr("app.exchange.imports.publish_run", fail)
        path = api.home / "a.xml"
        path.write_bytes(FOREIGN_FILE)
        said = {"yield": "stop"}
        incoming = ImportFile(path, "a.xml", unknown="add", label_map=said, author="ada")
        with pytest.raises(OSError, match="No space left"):
            context.imports.import_file(api.video_id, incoming, kind, api.run_id)  # type: ignore[arg-type]
    assert api.get("/api/label-sets/gtsrb-43/history") == before
    assert len(labels_of(api)) == 43
    with context.database.read() as session:
        assert session.scalars(select(LabelWord)).all() == []
    assert context.imports.import_file(api.video_id, incoming, kind, api.run_id).tracks == 2  # type: ignore[arg-type]


def _while_it_is_read(
    api: ExchangeClient, monkeypatch: pytest.MonkeyPatch, happens: Callable[[], object]
) -> ImportResult:
    """Import onto a set that changes between reading and storing."""
    read = imports_module.read_import_file

    def then(*given: Any) -> Any:
        found = read(*given)
        happens()
        return found

    monkeypatch.setattr(imports_module, "read_import_file", then)
    path = api.home / "a.xml"
    path.write_bytes(FOREIGN_FILE)
    incoming = ImportFile(path, "a.xml", unknown="add", author="ada")
    return api.server.context.imports.import_file(api.video_id, incoming, "run", api.run_id)


def _change(api: ExchangeClient, **change: Any) -> Any:
    return api.post("/api/label-sets/gtsrb-43/changes", {"author": "bob", "change": change})


def test_a_label_added_during_the_import(api: ExchangeClient, monkeypatch: pytest.MonkeyPatch) -> None:
    found = _while_it_is_read(api, monkeypatch, lambda: _change(api, type="add", name="bus stop"))
    assert labels_of(api)["pedestrian-crossing"]["id"] == 44
    assert {track.label for track in api.tracks(found.id).values()} == {44, 13}


def test_the_same_label_added_during_the_import(api: ExchangeClient, monkeypatch: pytest.MonkeyPatch) -> None:
    found = _while_it_is_read(api, monkeypatch, lambda: _change(api, type="add", name="Pedestrian crossing"))
    assert {track.label for track in api.tracks(found.id).values()} == {43, 13}
    assert {each["name"] for each in labels_of(api)["pedestrian-crossing"]["attributes"]} == {"lit", "side"}


def test_a_change_just_before_storing(api: ExchangeClient, monkeypatch: pytest.MonkeyPatch) -> None:
    """The set changes after the tracks were mapped to it, so they are mapped again."""
    write, once = imports_module.write_run, iter([True])

    def slow(*given: Any) -> Any:
        if next(once, False):
            _change(api, type="add", name="bus stop")
        return write(*given)

    monkeypatch.setattr(imports_module, "write_run", slow)
    found = _while_it_is_read(api, monkeypatch, lambda: None)
    assert {track.label for track in api.tracks(found.id).values()} == {44, 13}
    assert {"bus-stop", "pedestrian-crossing"} <= labels_of(api).keys()
    assert not list((api.home / "runs").glob(".import-*"))


def test_a_label_removed_during_the_import(api: ExchangeClient, monkeypatch: pytest.MonkeyPatch) -> None:
    version = _change(api, type="add", name="pedestrian_crossing")["version"]
    with pytest.raises(Conflict, match="label 'pedestrian_crossing' was removed from .* Import it again"):
        _while_it_is_read(api, monkeypatch, lambda: _change(api, type="undo", version=version))


def test_the_set_changed_during_the_import(api: ExchangeClient, monkeypatch: pytest.MonkeyPatch) -> None:
    def use() -> None:
        answer = api.server.client.put(f"/api/videos/{api.video_id}/label-set", json={"set": "vienna"})
        assert answer.status_code == 200, answer.text

    with pytest.raises(Conflict, match="now uses the label set .*Vienna.* the file was read with"):
        _while_it_is_read(api, monkeypatch, use)
    assert len(labels_of(api)) == 43


def test_attributes_of_an_annotation_round_trip(api: ExchangeClient) -> None:
    api.import_file(FOREIGN_FILE, "annotation", name="a.xml", unknown="add")
    (drawn,) = [track for track in api.tracks().values() if track.label == 43]
    assert drawn.attributes == {"side": "right"}
    assert drawn.changing["lit"].tolist() == [True] * 3 + [False] * 4
    content = api.download(api.export(format="coco", states=ALL_STATES))
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        reported = json.loads(archive.read("annotations/instances_default.json"))
    attributes = [note["attributes"] for note in reported["annotations"] if "side" in note["attributes"]]
    assert [each["lit"] for each in attributes] == [True] * 3 + [False] * 4
    again = api.import_file(content, "annotation", name="back.zip")
    assert (again["tracks"], again["edit"]) == (0, None), "nothing has changed"


def test_open_tracks_are_left_out_and_counted(api: ExchangeClient) -> None:
    made = api.export(states=["edited", "accepted", "rejected"])["summary"]
    assert made["counts"]["tracks"] == 0
    assert made["open_left"] == len(api.tracks())
    key = next(iter(api.tracks()))
    api.edit({"name": "set_review", "key": key, "frame": 1, "review": "accepted"}, {key: 0})
    made = api.export(states=["edited", "accepted", "rejected"])["summary"]
    assert (made["counts"]["tracks"], made["open_left"]) == (1, len(api.tracks()) - 1)
    other = list(api.tracks())[1]
    api.edit({"name": "relabel_track", "key": other, "frame": 1, "class_id": 14}, {other: 0})
    made = api.export(states=["rejected"])["summary"]
    assert made["open_left"] == len(api.tracks()) - 2, "a person has edited one of the open tracks"


def test_an_export_stores_the_places_of_tracks_that_it_leaves_out(api: ExchangeClient) -> None:
    def places(**request: Any) -> list[Any]:
        with zipfile.ZipFile(io.BytesIO(api.download(api.export(**request)))) as archive:
            (video,) = json.loads(archive.read("manifest.json"))["videos"]
        return list(video["left_out"])

    tracks = api.tracks()
    assert places(states=ALL_STATES) == []
    assert [one["frames"] for one in places(states=["edited"])] == [t.frames.tolist() for t in tracks.values()]
    key = next(iter(tracks))
    chosen = places(states=ALL_STATES, tracks={api.run_id: [key]})
    assert [one["frames"] for one in chosen] == [t.frames.tolist() for k, t in tracks.items() if k != key]


def test_signs_outside_the_set(api: ExchangeClient) -> None:
    key = next(iter(api.tracks()))
    api.edit({"name": "relabel_track", "key": key, "frame": 1, "class_id": -1}, {key: 0})
    count = len(api.tracks())
    left = api.export(format="mot", not_in_set="leave-out")["summary"]
    assert left["counts"]["tracks"] == count - 1
    assert any("no label of the set" in item["reason"] for item in left["skipped"])
    content = api.download(api.export(format="mot", not_in_set="ignore"))
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        rows = [row.split(",") for row in archive.read("gt/gt.txt").decode().splitlines()]
    assert {row[6] for row in rows} == {"0", "1"}
    request = {"runs": [api.run_id], "format": "yolo", "not_in_set": "ignore"}
    assert api.server.client.post("/api/exports", json=request).status_code == 422


def test_labels_are_chosen_by_key(api: ExchangeClient) -> None:
    tracks = api.tracks().values()
    stops = sum(track.label == 14 for track in tracks)
    assert api.export(labels=["stop"])["summary"]["counts"]["tracks"] == stops
    assert api.export(classes=[14])["summary"]["counts"]["tracks"] == stops
    assert api.export(labels=["stop, give way"])["state"] == "complete"
    assert "number 'stoop'. Is it 'stop'?" in api.export(labels=["stoop"])["error"]
