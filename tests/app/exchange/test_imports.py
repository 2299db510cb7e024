"""Imports over HTTP: completely or not at all; as ground truth, as a run, or as corrections that one undo reverts."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import numpy as np
import pytest
from sqlalchemy import select

from app.storage.models import Event
from tests.app.exchange.exchange_client import (
    ExchangeClient,
    assert_same_track,
    clipped_to_picture,
    table_of,
    unzipped,
    zipped,
)


def test_an_export_of_one_run_is_matched_by_position_in_another(api: ExchangeClient) -> None:
    """Both runs have an m1, for different signs."""
    exported = api.download(api.export(format="tracks-csv"))
    turned = table_of(exported).replace("m1,", "m0,").replace("m2,", "m1,").replace("m0,", "m2,")
    second = api.import_file(turned.encode(), "run", name="second.csv")["id"]
    original, imported = api.tracks(), api.tracks(second)
    np.testing.assert_allclose(imported["m2"].boxes, clipped_to_picture(original["m1"]).boxes, atol=0.1)
    found = api.import_file(exported, "annotation", run=second)
    assert (found["tracks"], found["same"]) == (0, 2), found
    assert api.import_file(exported, "annotation", run=api.run_id)["same"] == 2


def test_an_export_imported_as_a_run_is_the_same_run(read_only_api: ExchangeClient, api: ExchangeClient) -> None:
    """Boxes of the engine extend beyond the picture's edge, exported boxes do not."""
    table = api.server.context.evidence.boxes(api.run_id)
    assert (table.boxes[:, 2] > 320).any() or (table.boxes[:, :2] < 0).any() or (table.boxes[:, 3] > 240).any()
    content = read_only_api.download(read_only_api.export(format="tracks-csv"))
    imported_run = api.import_file(content, "run", name="back")["id"]
    found = api.get(f"/api/compare?reference=run:{api.run_id}&candidate=run:{imported_run}")
    values = {name: found["figures"][name]["value"] for name in ("precision", "recall", "coverage", "eq7")}
    assert values == {"precision": 1, "recall": 1, "coverage": 1, "eq7": pytest.approx(0, abs=1e-4)}
    assert found["figures"]["eq7"]["frames"] == []


def test_a_file_becomes_ground_truth(api: ExchangeClient, annotations: bytes) -> None:
    found = api.import_file(annotations, "truth", name="theirs.xml")
    assert (found["kind"], found["tracks"]) == ("truth", 2)
    ground_truths = api.get(f"/api/videos/{api.video_id}/ground-truths")["ground_truths"]
    assert [(truth["name"], truth["count"]) for truth in ground_truths] == [("theirs.xml", found["boxes"])]
    boxes = api.get(f"/api/ground-truths/{found['id']}/boxes?first=0&last=74")["boxes"]
    wanted = clipped_to_picture(api.tracks()["m1"])
    of_track = [box for box in boxes if box["track"] == 1]
    assert [box["frame"] for box in of_track] == wanted.frames.tolist()
    np.testing.assert_allclose([box["box"] for box in of_track], wanted.boxes, atol=0.51)
    assert {box["class_id"] for box in of_track} == {wanted.label}
    api.import_file(annotations, "truth", name="theirs.xml")
    assert len(api.get(f"/api/videos/{api.video_id}/ground-truths")["ground_truths"]) == 1, (
        "one of the same name is replaced"
    )


def test_a_file_becomes_a_run_for_every_screen(api: ExchangeClient, annotations: bytes) -> None:
    found = api.import_file(annotations, "run", name="their tracker")
    run_id = found["id"]
    run = api.get(f"/api/runs/{run_id}")
    assert (run["kind"], run["state"], run["name"], run["tracks"]) == ("imported", "complete", "their tracker", 2)
    tracks = api.get(f"/api/runs/{run_id}/tracks")
    assert tracks["id"] == [1, 2]
    assert tracks["complete"]
    assert len(api.get(f"/api/runs/{run_id}/lanes")["track"]) >= 2
    lane = api.get(f"/api/runs/{run_id}/tracks/1")
    assert "m1 in their tracker" in lane["events"][0]["text"]
    overlay = api.get(f"/api/runs/{run_id}/overlays?first=10&last=12")
    assert overlay["overlays"][0]["tracks"] or overlay["overlays"][1]["tracks"]
    for reference, candidate in ((api.run_id, run_id), (run_id, api.run_id)):
        compared = api.get(f"/api/compare?reference=run:{reference}&candidate=run:{candidate}")
        assert compared["figures"]
    answer = api.server.client.post(f"/api/runs/{run_id}/whatif", json={"parameters": {"tau": 3}})
    assert answer.status_code == 409
    assert "was imported" in answer.json()["error"]["message"]
    for key, track in api.tracks(run_id).items():
        assert track.source == "imported"
        assert_same_track(track, clipped_to_picture(api.tracks()[key]), 0.51)
    assert api.server.client.get(f"/api/runs/{run_id}/tracks/1/crop?frame=20&size=64").status_code in (200, 404)
    edited = {"name": "relabel_track", "key": "m1", "frame": 20, "class_id": 3}
    api.edit(edited, {"m1": 0}, run=run_id)  # it is reviewed like any run
    assert api.server.client.delete(f"/api/runs/{run_id}").status_code == 204
    assert not (api.home / "runs" / run_id).exists()


@pytest.mark.parametrize("name", ["run", "tracks.npz", "sent", "work", "..", "."])
def test_a_file_may_have_the_name_of_a_temporary_file(api: ExchangeClient, annotations: bytes, name: str) -> None:
    assert api.import_file(annotations, "run", name=name)["tracks"] == 2
    assert [path for path in (api.home / "uploads").iterdir() if path.name.startswith(".import")] == []


def test_an_imported_run_keeps_verdicts_and_notes(api: ExchangeClient) -> None:
    """Hidden stretches, verdicts and notes are the first operation of its log; ignored boxes cannot be kept."""
    api.make_corrections()
    content = api.download(api.export(format="tracks-json"))
    found = api.import_file(content, "run", name="theirs")
    wanted = {key: clipped_to_picture(track) for key, track in api.tracks().items()}
    numbered = dict(zip(("m1", "m2", "hdrawn01"), ("m1", "m2", "m3"), strict=True))
    there = api.tracks(found["id"])
    assert set(there) == set(numbered.values())
    for key, number in numbered.items():
        assert_same_track(there[number], wanted[key])
        assert there[number].notes == wanted[key].notes
        assert there[number].state == wanted[key].state
        assert there[number].source == "imported", "that it is hidden is nobody's word about a box"
    assert there["m1"].occluded.any()
    assert (there["m2"].state, found["skipped"]) == ("rejected", [])
    log = api.get(f"/api/runs/{found['id']}/edits")["edits"]
    assert [(entry["name"], entry["seq"]) for entry in log] == [("import", found["edit"])]
    api.undo(log[0]["author"], found["id"])
    bare = api.tracks(found["id"])
    assert not any(track.occluded.any() or track.notes or track.state != "open" for track in bare.values())


def test_ignored_boxes_are_reported_and_a_run_without_marks_has_no_log(api: ExchangeClient) -> None:
    rows = "frame,track_id,x1,y1,x2,y2,class_id,visibility,ignore\n3,1,10,10,30,30,14,1,1\n4,1,11,10,31,30,14,1,0\n"
    found = api.import_file(rows.encode(), "run", name="plain.csv", format="tracks-csv")
    assert [item["what"] for item in found["skipped"]] == ["1 marks 'ignore'"]
    assert found["edit"] is None
    assert api.get(f"/api/runs/{found['id']}/edits")["edits"] == []


def test_a_merge_fills_the_gaps_of_an_imported_track(api: ExchangeClient) -> None:
    places = [(frame, track) for track, frames in ((1, (3, 4, 7, 8)), (2, (5, 7, 10))) for frame in frames]
    rows = [f"{frame},{track},{10 * track},10,{10 * track + 9},30,14" for frame, track in places]
    content = "\n".join(["frame,track_id,x1,y1,x2,y2,class_id", *rows]).encode()
    run = api.import_file(content, "run", name="gappy.csv", format="tracks-csv")["id"]
    merge = {"name": "merge", "frame": 3, "key": "m1", "others": ["m2"]}
    api.edit(merge, {"m1": 0, "m2": 0}, run=run)
    (track,) = api.tracks(run).values()
    left_edges = dict(zip(track.frames.tolist(), track.boxes[:, 0].tolist(), strict=True))
    assert left_edges == {3: 10, 4: 10, 5: 20, 7: 10, 8: 10, 10: 20}


def test_corrections_from_elsewhere_are_one_operation(api: ExchangeClient, annotations: bytes) -> None:
    before = api.tracks()
    api.make_corrections()
    corrected = unzipped(api.download(api.export(states=["open", "accepted", "rejected"])))["annotations.xml"]
    wanted = api.tracks()
    log = len(api.get(f"/api/runs/{api.run_id}/edits")["edits"])
    back = api.import_file(annotations, "annotation", name="before.xml", author="bob")
    assert back["id"] == api.run_id
    assert (back["tracks"], back["same"]) == (1, 1), "m1 as it was; m2's boxes never changed; the drawn one stays"
    entries = api.get(f"/api/runs/{api.run_id}/edits")["edits"]
    assert len(entries) == log + 1
    assert (entries[-1]["name"], entries[-1]["author"], entries[-1]["seq"]) == ("import", "bob", back["edit"])
    assert_same_track(clipped_to_picture(api.tracks()["m1"]), clipped_to_picture(before["m1"]), 0.51)
    again = api.import_file(annotations, "annotation", name="before.xml", author="bob")
    assert (again["tracks"], again["same"], again["edit"]) == (0, 2, None), "nothing left to change"
    forth = api.import_file(corrected, "annotation", name="after.xml", author="bob")
    assert forth["tracks"] >= 1
    assert_same_track(clipped_to_picture(api.tracks()["m1"]), clipped_to_picture(wanted["m1"]), 0.51)


@pytest.mark.parametrize("name", ["cvat-video", "tracks-json", "mot", "gtsdb"])
def test_another_class_from_elsewhere_keeps_boxes_and_scores(api: ExchangeClient, name: str) -> None:
    before = api.tracks()
    content = unzipped(api.download(api.export(format=name, pictures="none")))
    api.edit({"name": "relabel_track", "key": "m1", "frame": 0, "class_id": 13}, {"m1": 0})
    relabelled = unzipped(api.download(api.export(format=name, pictures="none")))
    assert relabelled != content
    api.undo()
    found = api.import_file(zipped(relabelled), "annotation", name="relabelled.zip")
    assert (found["tracks"], found["same"]) == (1, 1)
    (document,) = api.get(f"/api/runs/{api.run_id}/annotation")["docs"]
    assert (document["class_id"], document["keys"]) == (13, {})
    assert [piece["track"] for piece in document["segments"]] == [1]
    after = api.tracks()["m1"]
    np.testing.assert_array_equal(after.boxes, before["m1"].boxes)
    np.testing.assert_array_equal(after.score, before["m1"].score)


def test_an_import_is_undone_and_redone_in_one_step(api: ExchangeClient, annotations: bytes) -> None:
    api.make_corrections()
    before = api.tracks()
    more = annotations.replace(b">m2<", b">somebody<")  # m2 is rejected: a track on it is another sign
    found = api.import_file(more, "annotation", name="a.xml", author="bob")
    assert found["tracks"] == 2, "m1 changes, the other is new to us"
    after = api.tracks()
    assert len(after) == len(before) + 1
    undone = api.undo("bob")
    assert undone["name"] == "import"
    for wanted in (before, after):
        now = api.tracks()
        assert set(now) == set(wanted)
        for key, track in now.items():
            assert_same_track(track, wanted[key], 0.0)
        if wanted is before:
            api.edit({"name": "redo", "op_id": undone["op_id"]}, {}, "bob")


def test_a_file_from_elsewhere_needs_no_names(api: ExchangeClient, annotations: bytes) -> None:
    nameless = annotations.replace(b">m1<", b"><").replace(b">m2<", b"><")
    found = api.import_file(nameless, "annotation", name="b.xml")
    assert (found["tracks"], found["same"]) == (0, 2), "what lies on our tracks is about them"
    relabelled = nameless.replace(b'label="stop"', b'label="give way"', 1).replace(
        b"<label><name>stop</name>", b"<label><name>give way</name></label><label><name>stop</name>", 1
    )
    found = api.import_file(relabelled, "annotation", name="c.xml")
    assert (found["tracks"], found["same"]) == (1, 1)
    assert sorted(api.tracks()) == ["m1", "m2"]
    assert 13 in {track.label for track in api.tracks().values()}


def test_a_sign_without_a_class_round_trips_and_can_be_reset(api: ExchangeClient) -> None:
    """No class is a correction; resetting restores the engine's class without a person's label."""
    engine = api.tracks()["m1"]

    def content() -> str:
        return table_of(api.download(api.export(format="tracks-csv")))

    def with_class(number: int, name: str) -> bytes:
        table = [row.split(",") for row in content().splitlines()]
        at, named, uid = (table[0].index(column) for column in ("class_id", "label", "uid"))
        for row in table[1:]:
            if row[uid] == "m1":
                row[at], row[named] = str(number), name
        return "\n".join(map(",".join, table)).encode()

    plain = content()
    found = api.import_file(with_class(-1, ""), "annotation", name="none.csv")
    assert (found["tracks"], found["same"]) == (1, 1)
    none = api.tracks()["m1"]
    assert (none.label, none.labels, none.source) == (-1, None, "corrected")
    assert_same_track(none, dataclasses.replace(engine, label=-1))
    for name in ("cvat-video", "coco", "tracks-json", "mot"):
        again = api.import_file(api.download(api.export(format=name)), "annotation", name=f"{name}.zip")
        assert (again["tracks"], again["same"]) == (0, 2), name
    figure = api.get(f"/api/compare?reference=run:{api.run_id}&candidate=annotation:{api.run_id}")
    assert {(cell["reference"], cell["candidate"]) for cell in figure["confusion"]["cells"]} >= {(engine.label, -1)}
    back = api.import_file(plain.encode(), "annotation", name="plain.csv")
    assert (back["tracks"], back["same"]) == (1, 1)
    assert api.tracks()["m1"].source == "engine"
    assert api.documents()["m1"].class_id is None


def test_a_merged_sign_is_not_doubled_in_another_run(api: ExchangeClient) -> None:
    """The engine lost a sign and found it again; in one run a person merged the two tracks."""
    exported = api.download(api.export(format="tracks-csv"))
    rows = table_of(exported).splitlines()
    head = rows[0].split(",")
    frame, uid, number = (head.index(column) for column in ("frame", "uid", "track_id"))
    track = api.tracks()["m1"]
    middle = int(track.frames[len(track.frames) // 2])
    later = [row.split(",") for row in rows[1:]]
    for row in later:
        if row[uid] == "m1" and int(row[frame]) >= middle:
            row[uid], row[number] = "m9", "9"
    broken = "\n".join([rows[0], *(",".join(row) for row in later)]).encode()
    first, second = (api.import_file(broken, "run", name=name)["id"] for name in ("first.csv", "second.csv"))
    merge = {"name": "merge", "frame": middle, "key": "m1", "others": ["m9"]}
    api.edit(merge, {"m1": 0, "m9": 0}, run=first)
    wanted = api.tracks(first)
    merged = api.download(api.export(runs=[first], format="tracks-json"))
    before = api.tracks(second)
    found = api.import_file(merged, "annotation", name="merged.zip", run=second)
    assert (found["tracks"], found["same"]) == (1, 1)
    assert "Track #9 of the run also lies on a track of the file and was merged into it." in found["repaired"]
    after = api.tracks(second)
    assert sorted(after) == sorted(wanted) == ["m1", "m2"]
    assert_same_track(after["m1"], wanted["m1"])
    assert np.isfinite(after["m1"].score).tolist() == np.isfinite(wanted["m1"].score).tolist()
    again = api.import_file(merged, "annotation", name="merged.zip", run=second)
    assert (again["tracks"], again["same"], again["edit"]) == (0, 2, None)
    api.undo(api.get(f"/api/runs/{second}/edits")["edits"][-1]["author"], second)
    assert sorted(api.tracks(second)) == sorted(before)


def test_a_mapped_name_becomes_its_class(read_only_api: ExchangeClient, annotations: bytes) -> None:
    api = read_only_api
    foreign_file = annotations.replace(b'"stop"', b'"Stopschild"').replace(b">stop<", b">Stopschild<")
    refused = api.send_import(foreign_file, "truth", name="x")
    assert (refused.status_code, refused.json()["error"]["code"]) == (422, "unknown_labels")
    mapped = api.import_file(foreign_file, "run", name="y", label_map=json.dumps({"Stopschild": 14}))
    assert not any("Stopschild" in sentence for sentence in mapped["repaired"])
    assert {track.label for track in api.tracks(mapped["id"]).values()} == {14}


def test_a_simultaneous_edit_is_not_overwritten(api: ExchangeClient, annotations: bytes, monkeypatch: Any) -> None:
    """An edit arrives before the import is stored: the import reads again, and its undo restores that edit."""
    import app.exchange.annotate_run as imports

    annotate, calls = imports.annotate, 0

    def slow(*arguments: Any) -> Any:
        nonlocal calls
        calls += 1
        if calls == 1:
            frame = int(api.tracks()["m1"].frames[5])
            api.edit({"name": "relabel_track", "key": "m1", "frame": frame, "class_id": 2}, {"m1": 0})
        return annotate(*arguments)

    monkeypatch.setattr(imports, "annotate", slow)
    found = api.import_inline(annotations, "annotation", "late.xml", "bob")
    assert calls == 2
    assert (found["tracks"], found["same"]) == (1, 1)
    assert api.tracks()["m1"].label == 14
    api.undo("bob")
    assert api.tracks()["m1"].label == 2


def test_the_event_of_a_large_import_has_no_documents(api: ExchangeClient) -> None:
    """Pages load the documents instead."""
    rows = "".join(f"{i % 75},{i},{i % 90},5,{i % 90 + 9},14,14\n" for i in range(600))
    content = b"frame,track_id,x1,y1,x2,y2,class_id\n" + rows.encode()
    found = api.import_file(content, "annotation", name="many.csv", author="bob")
    assert found["tracks"] == 600
    with api.server.context.database.read() as session:
        reported = session.scalars(select(Event).where(Event.kind == "edit")).all()[-1].data
    assert (reported["seq"], reported["docs"]) == (found["edit"], None)
