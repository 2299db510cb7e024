"""Labels and attributes in a file that the set does not have."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.exchange.small_datasets import make_dataset, make_label_set, make_track, make_video, target_of, tracks_of
from tsr_engine.errors import ExportError, ImportFormatError
from tsr_engine.exchange.added_labels import DeclaredLabel, UnknownLabels
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.relabel import unite_label_sets
from tsr_engine.exchange.split import make_split, missing_labels
from tsr_engine.labels.model import Attribute, Label, LabelSet


def _labels(*, key: str, number: int = 0, attributes: tuple[Attribute, ...] = (), name: str = "") -> LabelSet:
    label = Label(id=number, key=key, name=name or key, attributes=attributes)
    return LabelSet(key=f"set-{number}", name=f"set {number}", next_id=number + 1, labels=(label,))


def _add_rows(validator: ImportValidator, name: str, *rows: dict[str, object]) -> None:
    for frame, said in enumerate(rows):
        validator.box("a", frame, (0, 0, 9, 9), validator.label(name, "f"), file="f", attributes=said)


def test_names_that_differ_only_by_case_become_one_label() -> None:
    validator = ImportValidator(target_of(make_dataset(), unknown="add"))
    for frame, name in enumerate(("No_Stopping", "no stopping", "停车")):
        validator.box(name, frame, (0, 0, 9, 9), validator.label(name, "f"), file="f")
    found = validator.finish("f")
    assert [(label.id, label.key, label.name) for label in found.labels.labels[43:]] == [
        (43, "no-stopping", "No_Stopping"),
        (44, "停车", "停车"),
    ]
    assert [track.label for track in tracks_of(found).values()] == [43, 43, 44]


def test_some_names_of_a_file_are_added_and_others_left_out() -> None:
    lit = Attribute(name="lit", kind="checkbox", mutable=True)
    validator = ImportValidator(target_of(make_dataset(), unknown="skip", added=frozenset({"plate"})))
    validator.declare("plate", DeclaredLabel((lit,), "#00ff00"))
    validator.declare("tree", DeclaredLabel((lit,)))
    for name in ("plate", "tree", "stop"):
        validator.box(name, 1, (0, 0, 9, 9), validator.label(name, "f"), file="f", attributes={"lit": "true"})
    found = validator.finish("f")
    (plate,) = found.labels.labels[43:]
    assert (plate.name, plate.colour, plate.attributes) == ("plate", "#00ff00", (lit,))
    tracks = tracks_of(found)
    assert (tracks.keys(), tracks["plate"].changing["lit"].tolist()) == ({"plate", "stop"}, [True])
    assert sorted(item.what for item in found.skipped) == ["1 box of 1 track named 'tree'", "attribute 'lit'"]


def test_only_the_named_labels_are_added() -> None:
    validator = ImportValidator(target_of(make_dataset(), added=frozenset({"plate"})))
    for name in ("plate", "tree"):
        validator.box(name, 1, (0, 0, 9, 9), validator.label(name, "f"), file="f")
    with pytest.raises(UnknownLabels, match="1 name is no label of .*'tree'"):
        validator.finish("f")


@pytest.mark.parametrize("name", ["a\x00b", "x" * 300, "\u202egnorw"])
def test_invalid_label_names_are_refused(name: str) -> None:
    validator = ImportValidator(target_of(make_dataset(), unknown="add"))
    _add_rows(validator, name, {})
    with pytest.raises(ImportFormatError, match="cannot become a label"):
        validator.finish("f")


def test_attributes_are_reported_unless_added() -> None:
    reported = ImportValidator(target_of(make_dataset()))
    _add_rows(reported, "stop", {"lit": True}, {"lit": False})
    found = reported.finish("f")
    assert any(item.what.startswith("attribute 'lit'") and "unknown=add" in item.reason for item in found.skipped)
    added = ImportValidator(target_of(make_dataset(), unknown="add"))
    _add_rows(added, "stop", {"lit": "true", "height": 3, "by": "ada"}, {"lit": "false", "height": 3, "by": "ada"})
    found = added.finish("f")
    stop = found.labels.get(14)
    assert stop is not None
    kinds = {each.name: (each.kind, each.mutable) for each in stop.attributes}
    assert kinds == {"lit": ("checkbox", True), "height": ("number", False), "by": ("text", False)}
    (track,) = tracks_of(found).values()
    assert (track.attributes, track.changing["lit"].tolist()) == ({"height": 3.0, "by": "ada"}, [True, False])


def test_a_value_outside_the_set_is_reported() -> None:
    asked = Attribute(name="side", kind="select", values=("left", "right"))
    data = Dataset(_labels(key="arrow", attributes=(asked,)), make_dataset().videos)
    strict = ImportValidator(target_of(data))
    _add_rows(strict, "arrow", {"side": "both"})
    found = strict.finish("f")
    assert any("must be one of left, right" in item.reason for item in found.skipped)
    wide = ImportValidator(target_of(data, unknown="add"))
    _add_rows(wide, "arrow", {"side": "both"})
    found = wide.finish("f")
    assert found.labels.labels[0].attributes[0].values == ("left", "right", "both")
    assert tracks_of(found)["a"].attributes == {"side": "both"}


def test_declared_attribute_types_win_over_guessed_ones() -> None:
    validator = ImportValidator(target_of(make_dataset(), unknown="add"))
    validator.declare("plate", DeclaredLabel((Attribute(name="number", kind="text"),), "#00ff00"))
    _add_rows(validator, "plate", {"number": "0012"})
    found = validator.finish("f")
    assert found.labels.labels[43].colour == "#00ff00"
    assert tracks_of(found)["a"].attributes == {"number": "0012"}


def test_flags_of_voc_are_attributes(tmp_path: Path) -> None:
    (tmp_path / "frame_000010.xml").write_text(
        "<annotation><filename>frame_000010.jpg</filename><object><name>stop</name><pose>Left</pose>"
        "<truncated>1</truncated><bndbox><xmin>1.5</xmin><ymin>2</ymin><xmax>30</xmax><ymax>40</ymax></bndbox>"
        "</object></annotation>"
    )
    back = read_dataset(tmp_path, target_of(make_dataset(), unknown="add"))
    assert [track.attributes for track in tracks_of(back).values()] == [{"truncated": True, "pose": "Left"}]


def test_sets_are_merged_by_key_and_conflicting_keys_are_refused() -> None:
    first, second = _labels(key="stop"), _labels(key="bus", number=7)
    videos = [make_video([make_track("m1", label=number)], name=f"{number}.mp4") for number in (0, 7)]
    labels, parts = unite_label_sets([(first, videos[0]), (second, videos[1])])
    assert [label.key for label in labels] == ["stop", "bus"]
    assert [track.label for part in parts for track in part.tracks()] == [0, 1]
    with pytest.raises(ExportError, match="'stop' is 'stop' in set 0 and 'halt here' in set 7"):
        unite_label_sets([(first, videos[0]), (_labels(key="stop", number=7, name="halt here"), videos[1])])


def test_a_split_reports_missing_labels_and_can_balance_them() -> None:
    tracks = [make_track(f"m{at}", [at], label=int(at % 10 == 0)) for at in range(60)]
    data = Dataset(make_label_set("common", "rare"), (make_video(tracks),))
    shares = {"train": 0.8, "val": 0.1, "test": 0.1}
    seeds = [seed for seed in range(20) if missing_labels(data, make_split(data, shares, seed))]
    assert seeds, "chance alone leaves a side without the rare label"
    for seed in seeds:
        assert set().union(*missing_labels(data, make_split(data, shares, seed)).values()) == {"rare"}
        assert missing_labels(data, make_split(data, shares, seed, balance=True)) == {}
