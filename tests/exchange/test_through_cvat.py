"""Exports of CVAT for video after CVAT has stored them and exported them again."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from tests.exchange.small_datasets import CLASS_NAMES, make_dataset, make_track, target_of, tracks_of
from tsr_engine.exchange.dataset import Dataset, Track
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS


def through_cvat(folder: Path, *tracks: Track) -> Dataset:
    """Export tracks, import them into CVAT, export them from there, and read that file.

    CVAT 2 stores as the attributes of a whole track (``mutable`` is False) those of its last key frame
    (``_import_track`` in ``cvat/apps/dataset_manager/bindings.py``). A key frame that lacks an attribute gets the value
    of the key frame before (``get_interpolated_shapes`` in ``annotation.py``; cvat-ai/cvat#855). It writes a text of
    attributes without a value.
    """
    data = make_dataset(*tracks)
    export_dataset(data, FORMATS["cvat-video"], folder / "ours", zipped=False)
    tree = ET.parse(folder / "ours" / "annotations.xml")
    declared = {node.findtext("name", ""): node.findtext("mutable") for node in tree.iter("attribute") if len(node)}
    for track in tree.iter("track"):
        carried: dict[str, str] = {}
        of_track: dict[str, str] = {}
        for box in track.findall("box"):
            if box.get("keyframe") != "1":
                track.remove(box)
                continue
            values = {node.get("name", ""): node.text or "" for node in box.findall("attribute")}
            assert values.keys() <= declared.keys()
            of_track = {name: value for name, value in values.items() if declared[name] == "False"}
            carried |= {name: value for name, value in values.items() if declared[name] == "True"}
            for node in box.findall("attribute"):
                box.remove(node)
            for name, value in carried.items():
                ET.SubElement(box, "attribute", name=name).text = value
        for box in track.findall("box"):
            for name, value in of_track.items():
                ET.SubElement(box, "attribute", name=name).text = value
    tree.write(folder / "cvat.xml", encoding="utf-8")
    return read_dataset(folder / "cvat.xml", target_of(data))


def test_a_value_that_ends_does_not_hold_for_the_rest_of_the_track(tmp_path: Path) -> None:
    labels, ignore, score = np.full(30, 14), np.zeros(30, dtype=np.bool_), np.full(30, np.nan)
    labels[5:9] = 1
    ignore[12:20] = True
    score[:12] = 0.75
    track = make_track(labels=labels, ignore=ignore, score=score)
    back = tracks_of(through_cvat(tmp_path, track))["m1"]
    assert back.labels is not None
    assert back.labels.tolist() == labels.tolist()
    assert back.ignore is not None
    assert back.ignore.tolist() == ignore.tolist()
    assert np.isnan(back.score[12:]).all()


def test_another_label_in_cvat_holds_where_the_frame_has_none_of_its_own(tmp_path: Path) -> None:
    """Up to 2.67 CVAT keeps the values of attributes when a person changes the label (cvat-ai/cvat#11177)."""
    labels = np.full(30, 14)
    labels[5:9] = 1
    through_cvat(tmp_path, make_track(labels=labels))
    path = tmp_path / "cvat.xml"
    path.write_text(path.read_text().replace(f'label="{CLASS_NAMES[14]}"', f'label="{CLASS_NAMES[13]}"'))
    back = tracks_of(read_dataset(path, target_of(make_dataset())))["m1"]
    assert back.labels is not None
    assert back.labels.tolist() == np.where(labels == 14, 13, labels).tolist()


def test_a_track_that_ends_keeps_its_state_source_and_notes(tmp_path: Path) -> None:
    track = make_track(state="accepted", source="corrected", notes=((12, "a lamp?"),))
    back = tracks_of(through_cvat(tmp_path, track))["m1"]
    assert (back.state, back.source, back.notes) == (track.state, track.source, track.notes)
