"""Label sets in files of other tools: what each round-trips, reports, and refuses with its place."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from tsr_engine.errors import InputError, UsageError
from tsr_engine.exchange.cvat.common import OPTIONAL_ATTRIBUTES, label_lines
from tsr_engine.exchange.label_files.formats import LABEL_FORMATS, format_of, read_labels, write_labels
from tsr_engine.exchange.label_files.label_collector import FileLabels
from tsr_engine.exchange.labels import ClassMap
from tsr_engine.labels.files import shipped_set
from tsr_engine.labels.model import MAX_LABELS, Attribute, Label, LabelSet

SIDE = Attribute(name="side", kind="select", values=("left", "right, far"), default="left")
DIRTY = Attribute(name="dirty", kind="checkbox", default=False)
HEIGHT = Attribute(name="height <m>", kind="number", low=0.5, high=9.0, default=2.0)
FREE = Attribute(name="count", kind="number", default=-3.0)
TEXT = Attribute(name="plate", kind="text", default="a & b")
STRANGE = (
    Label(id=3, key="stop", name="stop", category="priority", colour="#ff0000", attributes=(SIDE, DIRTY), pinned=1),
    Label(
        id=7, key="nö", name="nö parking: <b>'x'</b>", aliases=("Parkverbot",), attributes=(DIRTY, HEIGHT, TEXT, FREE)
    ),
    Label(id=8, key="no", name="no", category="danger"),
    Label(id=9, key="stop-2", name="停车 🛑"),
    Label(id=10, key="hidden", name="hidden", hidden=True),
    Label(id=11, key="merged", name="merged", merged_into=3),
)
CUSTOM_SET = LabelSet(key="mine", name="Mine", next_id=20, labels=STRANGE)


def written_and_read(tmp_path: Path, labels: LabelSet, format: str) -> FileLabels:
    file = tmp_path / LABEL_FORMATS[format].file
    file.write_text(write_labels(labels, format), encoding="utf-8")
    assert format_of(file) == format
    return read_labels(file, "theirs", "Theirs")


def read(tmp_path: Path, content: str | bytes | list[Any] | dict[str, Any], file: str = "file") -> FileLabels:
    path = tmp_path / file
    text = content if isinstance(content, str | bytes) else json.dumps(content)
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_labels(path, "theirs", "Theirs")


@pytest.mark.parametrize("format", list(LABEL_FORMATS))
def test_names_round_trip_in_every_format(tmp_path: Path, format: str) -> None:
    found = written_and_read(tmp_path, CUSTOM_SET, format)
    assert [label.name for label in found.labels.offered()] == [label.name for label in STRANGE[:4]]
    assert not found.refused
    assert not found.reported
    shipped = shipped_set("gtsrb-43")
    assert [label.name for label in written_and_read(tmp_path, shipped, format).labels] == [
        label.name for label in shipped
    ]


def test_our_own_file_keeps_everything(tmp_path: Path) -> None:
    assert written_and_read(tmp_path, CUSTOM_SET, "tsr").labels == CUSTOM_SET


def test_cvat_keeps_colours_and_attributes(tmp_path: Path) -> None:
    found = written_and_read(tmp_path, CUSTOM_SET, "cvat").labels
    assert [label.colour for label in found] == ["#ff0000", None, None, None]
    assert [label.attributes for label in found] == [label.attributes for label in STRANGE[:4]]
    assert [label.id for label in found] == [0, 1, 2, 3]


def test_labels_for_cvat_declare_what_an_export_writes(tmp_path: Path) -> None:
    """CVAT drops attributes of an import that the labels of its task lack."""
    note, mutable = Attribute(name="note", kind="text", default="x"), [False] * 4 + [True] * 3
    labels = LabelSet(key="a", name="A", next_id=1, labels=(Label(id=0, key="a", name="a", attributes=(note, DIRTY)),))
    (written,) = json.loads(write_labels(labels, "cvat"))
    in_export = "".join(
        label_lines(ClassMap(labels.labels, False, True, True, {}, {}), OPTIONAL_ATTRIBUTES, mutable=True)
    )
    names = [each["name"] for each in written["attributes"]]
    assert names == re.findall("<attribute><name>(.*?)</name>", in_export)
    assert names[:7] == ["uid", "state", "source", "note", "score", "ignore", "frame_label"]
    assert [each["mutable"] for each in written["attributes"][:7]] == mutable
    assert written_and_read(tmp_path, labels, "cvat").labels.labels[0].attributes == (note, DIRTY)
    others = [{"name": "b", "attributes": [{"name": "state", "input_type": "text", "mutable": False, "values": []}]}]
    assert [each.name for each in read(tmp_path, others).labels.labels[0].attributes] == ["state"]


def test_coco_keeps_ids_and_categories(tmp_path: Path) -> None:
    found = written_and_read(tmp_path, CUSTOM_SET, "coco").labels
    assert [(label.id, label.category) for label in found] == [
        (3, "priority"),
        (7, "other"),
        (8, "danger"),
        (9, "other"),
    ]
    assert found.next_id == 10


def test_a_supercategory_among_the_categories_is_left_out(tmp_path: Path) -> None:
    """Roboflow lists the project as category 0 (roboflow/roboflow-100-benchmark#45); COCO has a person of persons."""
    categories = [
        {"id": 0, "name": "signs", "supercategory": "none"},
        {"id": 1, "name": "stop", "supercategory": "signs"},
        {"id": 2, "name": "person", "supercategory": "person"},
        {"id": 3, "name": "alone", "supercategory": "none"},
        {"id": 4, "name": "odd", "supercategory": ["signs"]},
        {"id": 5, "name": "none", "supercategory": "none"},
        {"id": 6, "name": "None"},
    ]
    found = read(tmp_path, {"categories": categories})
    assert [label.id for label in found.labels] == [1, 2, 3, 4, 5]
    assert found.reported[0] == "file: 'signs' is the supercategory of others; it was left out."


def test_label_studio_gets_the_frame_rate_of_the_task(tmp_path: Path) -> None:
    """``<Video>`` without ``framerate`` counts 24 frames a second (labelstud.io/tags/video)."""
    assert '<Video name="video" value="$video" framerate="$fps"/>' in write_labels(CUSTOM_SET, "label-studio")


def test_label_studio_keeps_aliases_digits_colours_and_attributes(tmp_path: Path) -> None:
    labels = LabelSet(key="a", name="a", next_id=20, labels=STRANGE[:2])
    found = written_and_read(tmp_path, labels, "label-studio").labels
    first, second = found
    assert (first.pinned, first.colour, first.attributes) == (1, "#ff0000", (SIDE, DIRTY))
    assert second.aliases == ("Parkverbot",)
    assert sorted(second.attributes, key=str) == sorted((DIRTY, HEIGHT, TEXT, FREE), key=str)


def test_yolo_numbers_are_positions_in_the_list(tmp_path: Path) -> None:
    assert yaml.safe_load(write_labels(CUSTOM_SET, "yaml")) == {
        "names": {at: label.name for at, label in enumerate(STRANGE[:4])}
    }
    found = read(tmp_path, "train: a\nnames: {3: stop, 1: no, 7: 1.50}\n", "a.yaml").labels
    assert [(label.id, label.name) for label in found] == [(1, "no"), (3, "stop"), (7, "1.50")]
    assert [label.name for label in read(tmp_path, "names: [yes, 'b c']\n").labels] == ["yes", "b c"]


def test_cvats_own_file_is_read(tmp_path: Path) -> None:
    found = read(
        tmp_path,
        [
            {
                "name": "car",
                "id": 8661,
                "color": "#9988FF",
                "type": "skeleton",
                "attributes": [
                    {
                        "id": 1,
                        "name": "make",
                        "input_type": "radio",
                        "mutable": True,
                        "values": ["a", "b"],
                        "default_value": "c",
                    },
                    {
                        "name": "x",
                        "input_type": "number",
                        "mutable": False,
                        "values": ["0", "9", "0.5"],
                        "default_value": "1",
                    },
                    {"name": "broken", "input_type": "select", "mutable": False, "values": []},
                    {"name": "x", "input_type": "text", "mutable": False, "values": [""]},
                ],
            },
            {"name": "Car", "color": "red"},
        ],
    )
    (car,) = found.labels
    assert (car.id, car.colour) == (0, "#9988ff")
    assert [(each.name, each.kind, each.mutable, each.default) for each in car.attributes] == [
        ("make", "select", True, None),
        ("x", "number", False, 1.0),
    ]
    assert (car.attributes[1].low, car.attributes[1].high) == (0, 9)
    assert [refused.reason for refused in found.refused] == ["file, label 2: 'Car' is the same label as 'car' here."]
    assert [sentence.partition(": ")[2] for sentence in found.reported] == [
        "'car' is a label for skeleton; it was taken as one for boxes.",
        "the default of 'make' is not one of its values; it was left out.",
        "the step of 'x' is not kept.",
        "an attribute was left out: attribute 'broken': a select has values, and nothing else has.",
        "the attribute 'x' occurs twice; the first counts.",
        "the colour of 'Car' was left out: 'red' is not in the form #rrggbb.",
    ]


def test_a_handwritten_label_studio_configuration_is_read(tmp_path: Path) -> None:
    found = read(
        tmp_path,
        """<View><Style>.a {}</Style><Header value="Signs"/>
        <View className="left"><RectangleLabels name="l" toName="img">
          <Label value="Stop" alias="stop_sign" background="red" hotkey="1"/>
          <Label value="Yield" background="rgba(0,0,255,0.5)" hotkey="y"/>
          <Label value="No" background="no colour" hotkey="1"/>
        </RectangleLabels></View>
        <Choices name="state" toName="img" perRegion="true" whenTagName="l" whenLabelValue="Stop,No">
          <Choice value="fine" selected="true"/><Choice value="bent"/></Choices>
        <Choices name="weather" toName="img"><Choice value="rain"/></Choices>
        <Choices name="many" toName="img" perRegion="true" choice="multiple"><Choice value="a"/></Choices>
        <Number name="n" toName="img" perRegion="true" min="0" max="5"/></View>""",
    )
    stop, give_way, no = found.labels
    assert (stop.aliases, stop.colour, stop.pinned) == (("stop_sign",), "#ff0000", 1)
    assert (give_way.colour, give_way.pinned, no.colour, no.pinned) == ("#0000ff", None, None, None)
    assert [[each.name for each in label.attributes] for label in found.labels] == [
        ["state", "n"],
        ["n"],
        ["state", "n"],
    ]
    assert stop.attributes[0].default == "fine"
    assert len(found.reported) == 5
    only = read(tmp_path, '<View><Choices name="a" toName="b"><Choice value="x"/></Choices></View>')
    assert [label.name for label in only.labels] == ["x"]


@pytest.mark.parametrize(
    ("content", "file", "reported"),
    [
        ("", "a", "a: is empty"),
        ("{", "a", "not JSON"),
        ("{}", "a.json", "a.json: has no list of categories"),
        (
            {"categories": [{"id": 1, "name": "a"}, {"id": 1, "name": "b"}]},
            "a",
            "category 2: 'b' has the number 1 of 'a'",
        ),
        ({"categories": [{"id": "1", "name": "a"}]}, "a", "category 1: id must be a whole number"),
        ({"categories": [{"id": -1, "name": "a"}]}, "a", "must be 0 to"),
        ({"categories": []}, "a", "has no labels"),
        ([{"id": 1}], "a", "label 1: must be an object with a name"),
        ([{"name": "a", "attributes": 3}], "a", "attributes must be a list"),
        ([{"name": "a", "attributes": [{"name": "x", "input_type": "dial"}]}], "a", "input_type checkbox, select"),
        (
            [{"name": "a", "attributes": [{"name": "x", "input_type": "number", "values": ["low"]}]}],
            "a",
            "'low' in an attribute of 'a' must be a number",
        ),
        ("a\n\nb\n", "obj.names", "obj.names, line 2: is empty"),
        (b"a\n\xff\n", "obj.names", "obj.names"),
        (b"\x00\x01", "obj.names", "not a file of labels"),
        ("names: 3\n", "data.yaml", "must be a list or a map"),
        ("a: 3\n", "data.yaml", "has no names"),
        ("names: !!python/object:os.system [a]\n", "data.yaml", "tag"),
        ("<annotation/>", "a.xml", "outermost element is <annotation>, must be <View>"),
        ('<!DOCTYPE a [<!ENTITY b "c">]><View>&b;</View>', "a.xml", "DOCTYPE or entity"),
        ("<View><Labels><Label/></Labels></View>", "a.xml", "line 1: <Label> must have value"),
        ("<View>" * 40 + "</View>" * 40, "a.xml", "nested deeper"),
        ("<View/>", "a.xml", "has no labels"),
        ('{"schema": 2, "labels": []}', "a.json", "Update tsr"),
        ('{"schema": 1, "key": "a", "name": "b"' + "[" * 100_000, "a.json", "not JSON"),
        ([{"name": f"label {n}"} for n in range(MAX_LABELS + 1)], "a", f"more than the {MAX_LABELS} labels"),
        (
            {"schema": 1, "key": "a", "name": "b", "labels": [{"id": n} for n in range(2 * MAX_LABELS)]},
            "a.json",
            f"has {2 * MAX_LABELS} labels",
        ),
    ],
)
def test_a_broken_rule_is_refused_in_a_sentence(tmp_path: Path, content: Any, file: str, reported: str) -> None:
    with pytest.raises(InputError) as refused:
        read(tmp_path, content, file)
    assert reported in str(refused.value)
    assert str(refused.value).endswith(".")


@pytest.mark.parametrize("name", ["a\u202eb", "x" * 201, "a\x07b", " "])
def test_an_invalid_name_is_refused_and_the_others_stay(tmp_path: Path, name: str) -> None:
    found = read(tmp_path, [{"name": "stop"}, {"name": name}, {"name": "تقاطع"}, {"name": "<script>"}])
    assert [label.name for label in found.labels] == ["stop", "تقاطع", "<script>"]
    assert [refused.name for refused in found.refused] == [name.strip()]
    assert found.refused[0].reason.startswith("file, label 2: ")


def test_keys_never_match_another_labels_name(tmp_path: Path) -> None:
    found = read(tmp_path, "a+b\nAB\nxa+b*c\nxa+bc\n🛑\n🚧\n").labels
    assert [label.key for label in found] == ["a-b-2", "ab", "xa-b-c", "xa-bc-2", "label", "label-2"]


def test_an_unknown_format_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("a")
    with pytest.raises(UsageError, match="one of tsr, cvat, names, yaml, coco, label-studio. Got 'xls'"):
        read_labels(tmp_path / "a", "a", "a", "xls")
    with pytest.raises(UsageError, match="Got 'xls'"):
        write_labels(CUSTOM_SET, "xls")
    with pytest.raises(InputError, match="cannot be read"):
        read_labels(tmp_path / "missing", "a", "a")
