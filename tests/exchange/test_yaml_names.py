"""Class names in YOLO's ``data.yaml``, in every YAML notation."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.exchange.image_datasets import yolo_folder
from tests.exchange.small_datasets import make_dataset, make_label_set, target_of, tracks_of
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.added_labels import UnknownLabels
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.yolo.class_names import MAX_YAML_BYTES, quoted_name, read_class_names

BOTH = {0: "stop", 1: "it's 50"}


def read(folder: Path, text: str | bytes) -> dict[int, str] | None:
    path = folder / "data.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_class_names(path)


@pytest.mark.parametrize(
    "text",
    [
        "names:\n  0: stop\n  1: 'it''s 50'\n",
        'nc: 2\nnames: [stop, "it\'s 50"]  # two\n',
        'names: {0: stop, 1: "it\'s 50"}\n',
        "names:\n- stop\n- it's 50\nnc: 2\n",
        'names: [\n  "stop",\n  "it\'s 50",\n]\n',
        '"names":\n  "0": stop\n  \'1\': it\'s 50\n',
        "'names' :\n    0: stop\n    1: it's 50\n",
        '{"train": "a", "names": {"0": "stop", "1": "it\'s 50"}}\n',
        "? names\n: ? 0\n  : stop\n  ? 1\n  : it's 50\n",
        "all: &all [stop, it's 50]\nnames: *all\n",
        "names: &n\n  1: it's 50\n  0: stop\nval: x\n",
        "%YAML 1.2\n---\nnames:\n  - &first stop\n  - it's 50\n...\n",
        "names:\n  - !!str stop\n  - >-\n    it's\n    50\n",
        "\ufeffnames: [stop, it's 50]\n",
        "names: [stop, it's 50]\r\ntrain: x\r\n",
    ],
)
def test_every_notation_of_names(tmp_path: Path, text: str) -> None:
    assert read(tmp_path, text) == BOTH


def test_names_round_trip(tmp_path: Path) -> None:
    hard = ['a: "b" # c', "", "\\ \x85\u2028\x07", "[x, y]", "Überholen 停", "😀", "null", "- x", "\x7f\ufeff"]
    text = "names:\n" + "".join(f"  {k}: {quoted_name(name)}\n" for k, name in enumerate(hard))
    assert read(tmp_path, text) == dict(enumerate(hard))


def test_names_are_kept_as_text(tmp_path: Path) -> None:
    written = ["no", "on", "30", "1.50", "2024-05-01", "0x1F", "~", "12:30"]
    assert read(tmp_path, f"names: [{', '.join(written)}]") == dict(enumerate(written))


@pytest.mark.parametrize("text", ["", "# nothing\n", "nc: 2\ntrain: x\n", "info:\n  names: [a]\n"])
def test_without_names(tmp_path: Path, text: str) -> None:
    assert read(tmp_path, text) is None


def test_an_empty_list_of_names(tmp_path: Path) -> None:
    assert read(tmp_path, "names:\nnc: 2\n") == {}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("train: x\nnames: [a\nnc: 2\n", "line 3: is not YAML: .*Quote names that hold marks"),
        ("names:\n  0: limit: 30\n", "line 2: is not YAML: .*Quote names"),
        ("names:\n\t0: a\n", "line 2: is not YAML"),
        ("names: [a]\n---\nnames: [b]\n", "line 2: is not YAML"),
        ("names: *gone\n", "line 1: is not YAML: found undefined alias"),
        ("names: [a]\nnc: 1\nnames: [b]\n", "line 3: has names twice. Delete one"),
        ("names:\n  0: a\n  1: b\n  0: c\n", "line 4: class 0 occurs twice. Give each class its own number"),
        ('names:\n  0: a\n  "0": c\n', "line 3: class 0 occurs twice"),
        ("names:\n  stop: 14\n", "line 2: a name must be written '0: stop', by the number of its class. Got 'stop'"),
        ("names:\n  -1: a\n", "line 2: a name must be written"),
        ("names:\n  [1]: a\n", "line 2: a name must be written .* Got a list"),
        ("names:\n  - 0: stop\n", "line 2: a name must be a text. Got a map"),
        ("names: [[stop]]\n", "line 1: a name must be a text. Got a list"),
        ("a: 1\nnames: classes.txt\n", "line 2: names must be a list or a map, .* Got 'classes.txt'"),
        ("names: &a [*a]\n", "line 1: a name must be a text. Got a list"),
        ("base: &b {names: [a]}\n<<: *b\n", r"line 2: a merge key \(<<\) is not read"),
        ("names:\n  <<: {0: a}\n  1: b\n", "line 2: a name must be written .* Got '<<'"),
        ("names: !!python/object/apply:os.getcwd []\n", "line 1: the tag .*python/object.* is not read"),
        ("names: [!secret a]\n", "line 1: the tag '!secret' is not read"),
        ("- a\n- b\n", "line 1: must be a map with names"),
        ("just text", "line 1: must be a map with names"),
        ("names: [\x01]\n", "is not YAML"),
        ("names: " + "[" * 100_000, "is not YAML|nested too deeply"),
        ("names: [Überholverbot]\n".encode("latin-1"), "line 1: byte 0xdc is not UTF-8"),
        ("#" * (MAX_YAML_BYTES + 1), "more than the 1048576 that are read"),
    ],
)
def test_errors_name_the_line(tmp_path: Path, text: str | bytes, words: str) -> None:
    with pytest.raises(ImportFormatError, match=f"^data.yaml(, |: |.*){words}"):
        read(tmp_path, text)


def test_nested_aliases_do_not_use_memory(tmp_path: Path) -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]" for k in range(1, 60)]
    assert read(tmp_path, "\n".join([*lines, "names: [stop]\n"])) == {0: "stop"}
    with pytest.raises(ImportFormatError, match="a name must be a text"):
        read(tmp_path, "\n".join([*lines, "names: *a59\n"]))


def test_quoted_names_in_an_import(tmp_path: Path) -> None:
    """As a user's script writes it: number 0 is a stop sign, not the tool's class 0."""
    yolo_folder(tmp_path, "0 0.5 0.5 0.0625 0.1\n", names='"names":\n  0: stop\n')
    found = read_dataset(tmp_path, target_of(make_dataset()))
    (track,) = tracks_of(found).values()
    assert track.label == 14
    assert not any("has no class names" in sentence for sentence in found.repaired)


def test_gtsrb_classes_named_by_number(tmp_path: Path) -> None:
    """Common in files. The numbers in any other list are names, which the user must map."""
    row = "14 0.5 0.5 0.0625 0.1\n"
    yolo_folder(tmp_path, row, names=f"names: {[str(number) for number in range(43)]}\n")
    team = make_label_set("yield", "stop")
    team = team.model_copy(update={"labels": (team.labels[0], team.labels[1].model_copy(update={"key": "stop"}))})
    found = read_dataset(tmp_path, target_of(Dataset(team, make_dataset().videos)))
    assert [track.label for track in tracks_of(found).values()] == [1]
    assert any("data.yaml: 43 classes have their numbers as names" in sentence for sentence in found.repaired)
    yolo_folder(tmp_path, row, names=f"names: {[str(number) for number in range(42)]}\n")
    with pytest.raises(UnknownLabels, match="'14'"):
        read_dataset(tmp_path, target_of(make_dataset()))
