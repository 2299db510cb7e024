"""Changes of a label set: effect, refusals and undo."""

from __future__ import annotations

import time
from typing import Any

import pytest

from tests.labels.test_label_set import make_label, make_set
from tests.waiting import time_limit
from tsr_engine.labels.adopting import adopt_labels
from tsr_engine.labels.changes import add_label, hide_label, key_of, merge_labels, set_picture, show_label, update_label
from tsr_engine.labels.conflicts import ChangeError, NoLabelError, TakenError
from tsr_engine.labels.files import shipped_set
from tsr_engine.labels.model import MAX_LABELS, Label, LabelSet
from tsr_engine.labels.undo import undo_change

STOP, YIELD = make_label(1, "stop", aliases=("halt",), pinned=1), make_label(2, "give-way", name="give way")
CUSTOM_SET = make_set(STOP, YIELD)


def unused(_: int) -> bool:
    return False


def used(_: int) -> bool:
    return True


@pytest.mark.parametrize(
    ("name", "key"),
    [
        ("No Parking!", "no-parking"),
        ("  Megállni tilos ", "megállni-tilos"),
        ("停车 检查", "停车-检查"),
        ("قف", "قف"),
        ("max. 7,5 t", "max-7-5-t"),
        ("snake_case", "snake-case"),
        ("🚧", "label"),
        ("<b>bold</b>", "b-bold-b"),
        ("x" * 200, "x" * 80),
    ],
)
def test_a_key_is_made_from_any_name(name: str, key: str) -> None:
    assert key_of(name) == key
    assert key_of(name, {key, f"{key}-2"}.__contains__) == f"{key}-3"


def test_a_label_is_added_with_the_next_id() -> None:
    done = add_label(CUSTOM_SET, {"name": "no parking", "attributes": [{"name": "side", "kind": "text"}], "pinned": 2})
    assert done.sentence == "Added 'no parking'."
    assert done.label is not None
    assert (done.label.id, done.label.key) == (100, "no-parking")
    assert (done.labels.version, done.labels.next_id) == (2, 101)
    assert done.labels.labels == (*CUSTOM_SET.labels, done.label)
    again = add_label(done.labels, {"name": "no/parking zone", "key": "x"})
    assert again.label is not None
    assert again.label.id == 101


def test_names_that_make_one_key_get_two() -> None:
    first = add_label(CUSTOM_SET, {"name": "A+B"}).labels
    second = add_label(first, {"name": "A*B"}).label
    assert second is not None
    assert second.key == "a-b-2"
    assert [add_label(CUSTOM_SET, {"name": name}).label.key for name in ("🚧", "مدرسة", "a\u200db")] == [  # type: ignore[union-attr]
        "label",
        "مدرسة",
        "a-b",
    ]


@pytest.mark.parametrize(
    ("fields", "field", "reported"),
    [
        ({"name": "Stop"}, "name", "The name 'Stop' belongs to 'stop' (label 1, key stop)."),
        ({"name": "HALT"}, "name", "The name 'HALT' belongs to 'stop' (label 1, key stop)."),
        ({"name": "x", "aliases": ["Give Way"]}, "aliases", "The alias 'Give Way' belongs to 'give way' (label 2, "),
        ({"name": "x", "key": "STOP"}, "key", "The key 'STOP' belongs to 'stop'"),
        ({"name": "x", "pinned": 1}, "pinned", "The digit 1 belongs to 'stop' (label 1)."),
    ],
)
def test_a_taken_value_is_refused_with_its_label(fields: dict[str, Any], field: str, reported: str) -> None:
    changes = [
        lambda: add_label(CUSTOM_SET, fields),
        lambda: update_label(make_set(*CUSTOM_SET, make_label(3, "y")), 3, fields),
    ]
    for change in changes[: 1 if field == "key" else 2]:
        with pytest.raises(TakenError) as refused:
            change()
        assert str(refused.value).startswith(reported)
        assert refused.value.field == field
        assert refused.value.label in (STOP, YIELD)


@pytest.mark.parametrize(
    ("fields", "field", "reported"),
    [
        ({}, "name", "Name: Field required."),
        ({"name": ""}, "name", "Name: "),
        ({"name": "a\u202eb"}, "name", "control character U\\+202E"),
        ({"name": "a", "short": "a\nb"}, "short", "control character U\\+000A"),
        ({"name": "a", "colour": "red"}, "colour", "Colour: "),
        ({"name": "a", "mirror": "nothing"}, "mirror", "which is not a key of the set"),
        ({"name": "a", "attributes": [{"name": "b", "kind": "select"}]}, "attributes", "a select has values"),
        ({"name": "a", "nonsense": 1}, "nonsense", "Nonsense: "),
        ({"name": "a", "size_mm": -1}, "size_mm", "greater than 0"),
    ],
)
def test_a_wrong_field_is_one_sentence(fields: dict[str, Any], field: str, reported: str) -> None:
    with pytest.raises(ChangeError, match=reported) as refused:
        add_label(CUSTOM_SET, fields)
    assert refused.value.field == field
    assert str(refused.value).endswith(".")


def test_changed_fields_are_listed_in_the_sentence() -> None:
    done = update_label(CUSTOM_SET, 2, {"name": "yield"})
    assert done.sentence == "Renamed 'give way' to 'yield'."
    assert done.label == make_label(2, "give-way", name="yield")
    done = update_label(done.labels, 2, {"aliases": ["Vorfahrt"], "teach": "ignore", "pinned": 9})
    assert done.sentence == "Changed aliases, teach and digit of 'yield'."
    assert update_label(done.labels, 2, {"pinned": None}).label.pinned is None  # type: ignore[union-attr]
    same = update_label(CUSTOM_SET, 2, {"name": "give way"})
    assert same.labels is CUSTOM_SET
    with pytest.raises(ChangeError, match="'key' of a label cannot be changed"):
        update_label(CUSTOM_SET, 2, {"key": "other"})
    with pytest.raises(NoLabelError, match="has no label 7"):
        update_label(CUSTOM_SET, 7, {"name": "a"})


def test_merged_labels_are_resolved_and_undo_separates_them() -> None:
    merged = merge_labels(CUSTOM_SET, 1, 2)
    assert merged.sentence == "Merged 'stop' into 'give way'."
    assert merged.labels.resolved(1) == 2
    assert merged.labels.get(1).pinned is None  # type: ignore[union-attr]
    with pytest.raises(ChangeError, match=r"'stop' is merged into 'give way' \(label 2\)"):
        update_label(merged.labels, 1, {"name": "a"})
    with pytest.raises(ChangeError, match="into itself: 'stop' is merged into it"):
        merge_labels(merged.labels, 2, 1)
    with pytest.raises(ChangeError, match="cannot be merged into itself"):
        merge_labels(CUSTOM_SET, 2, 2)
    back = undo_change(merged.labels, CUSTOM_SET, merged.labels, merged.sentence, used)
    assert back.labels.labels == CUSTOM_SET.labels
    assert back.labels.version == 3
    assert back.sentence == "Took back version 2: Merged 'stop' into 'give way'."
    again = undo_change(back.labels, merged.labels, back.labels, back.sentence, used)
    assert again.labels.labels == merged.labels.labels


def test_a_chain_of_merges_ends_in_one_label() -> None:
    first = merge_labels(make_set(*CUSTOM_SET, make_label(3, "c")), 1, 2).labels
    second = merge_labels(first, 2, 3)
    assert [second.labels.resolved(number) for number in (1, 2, 3)] == [3, 3, 3]
    with pytest.raises(ChangeError, match="into itself"):
        merge_labels(second.labels, 3, 1)


def test_hidden_labels_keep_their_names_and_can_be_shown_again() -> None:
    hidden = hide_label(CUSTOM_SET, 1)
    assert hidden.sentence == "Hid 'stop'."
    assert [label.id for label in hidden.labels.offered()] == [2]
    with pytest.raises(TakenError, match=r"\(label 1, key stop, hidden\)"):
        add_label(hidden.labels, {"name": "stop"})
    assert hide_label(hidden.labels, 1).labels is hidden.labels
    assert show_label(hidden.labels, 1).label == STOP.model_copy(update={"pinned": None})
    assert show_label(CUSTOM_SET, 1).labels is CUSTOM_SET


def test_a_picture_is_set_and_removed() -> None:
    done = set_picture(CUSTOM_SET, 1, "sha256:" + "0" * 64)
    assert done.sentence == "Gave 'stop' a picture."
    assert set_picture(done.labels, 1, "").sentence == "Took the picture of 'stop' away."


def test_undoing_an_older_change_keeps_newer_ones() -> None:
    v2 = update_label(CUSTOM_SET, 1, {"name": "STOP sign"})
    v3 = add_label(v2.labels, {"name": "no parking"})
    v4 = update_label(v3.labels, 1, {"colour": "#ff0000"})
    back = undo_change(v4.labels, CUSTOM_SET, v2.labels, v2.sentence, unused)
    assert back.labels.version == 5
    assert back.labels.get(1) == STOP.model_copy(update={"colour": "#ff0000"})
    assert back.labels.get(100) == v3.label
    v5 = update_label(v4.labels, 1, {"name": "third"})
    with pytest.raises(ChangeError, match="Version 2 cannot be taken back: a later version has changed 'third' again"):
        undo_change(v5.labels, CUSTOM_SET, v2.labels, v2.sentence, unused)
    nothing = undo_change(back.labels, CUSTOM_SET, v2.labels, v2.sentence, unused)
    assert nothing.labels is back.labels


def test_an_added_label_in_use_is_kept_on_undo() -> None:
    added = add_label(CUSTOM_SET, {"name": "no parking"})
    gone = undo_change(added.labels, CUSTOM_SET, added.labels, added.sentence, unused)
    assert gone.labels.labels == CUSTOM_SET.labels
    assert gone.labels.next_id == 101  # the id is never reused
    assert (
        undo_change(gone.labels, added.labels, gone.labels, gone.sentence, unused).labels.labels == added.labels.labels
    )
    kept = undo_change(added.labels, CUSTOM_SET, added.labels, added.sentence, used)
    assert kept.labels.get(100).hidden  # type: ignore[union-attr]
    assert "Tracks may use no parking: hidden, not removed." in kept.sentence
    merged = merge_labels(added.labels, 1, 100).labels
    assert undo_change(merged, CUSTOM_SET, added.labels, added.sentence, unused).labels.get(100).hidden  # type: ignore[union-attr]


def test_undo_is_refused_if_a_name_was_taken_since() -> None:
    merged = merge_labels(CUSTOM_SET, 1, 2)
    with_new = add_label(merged.labels, {"name": "stop", "key": "stop-2"})
    with pytest.raises(TakenError, match="The name 'stop' belongs to 'stop'|The key 'stop' belongs to 'stop'"):
        undo_change(with_new.labels, CUSTOM_SET, merged.labels, merged.sentence, unused)


def test_adopting_a_set_adds_missing_labels_and_matches_known_ones() -> None:
    other = LabelSet(
        key="theirs",
        name="Theirs",
        next_id=50,
        labels=(
            make_label(4, "HALT", mirror="left"),
            make_label(5, "left", mirror="right", pinned=1),
            make_label(6, "right", mirror="left", pinned=7),
            make_label(7, "old right", merged_into=6),
            make_label(8, "gone", hidden=True),
            make_label(9, "40"),
        ),
    )
    done = adopt_labels(CUSTOM_SET, other)
    assert done.changed.sentence == "Added 5 labels of 'Theirs'."
    assert {key: label.id for key, label in done.known.items()} == {"HALT": 1}
    assert [(label.id, label.key, label.pinned) for label in done.added] == [
        (100, "left", None),
        (101, "right", 7),
        (102, "gone", None),
        (103, "40", None),
        (104, "old right", None),
    ]
    now = done.changed.labels
    assert now.resolved(104) == 101
    assert now.next_id == 105
    assert now.get(102).hidden  # type: ignore[union-attr]
    again = adopt_labels(now, other)
    assert again.changed.labels is now
    assert len(again.known) == 6
    assert again.changed.sentence == "All labels of 'Theirs' are here already."


def test_mirror_images_are_mapped_on_adoption() -> None:
    mine = make_set(make_label(1, "links", aliases=("left",)))
    other = LabelSet(
        key="t", name="T", next_id=9, labels=(make_label(1, "left"), make_label(2, "right", mirror="left"))
    )
    assert adopt_labels(mine, other).added[0].mirror == "links"


def test_the_shipped_set_adopts_itself_whole() -> None:
    shipped = shipped_set("gtsrb-43")
    assert adopt_labels(shipped, shipped).changed.labels is shipped
    assert adopt_labels(make_set(), shipped).changed.labels.labels[5].key == shipped.labels[5].key


def test_a_full_set_refuses_labels_and_is_fast_before() -> None:
    labels = tuple(
        Label(id=i, key=f"label-{i}", name=f"Label number {i}", aliases=(f"alias {i}",)) for i in range(MAX_LABELS - 1)
    )
    large = LabelSet(key="large", name="Large", next_id=MAX_LABELS, labels=labels)
    began = time.perf_counter()
    full = add_label(large, {"name": "the last"}).labels
    assert time.perf_counter() - began < time_limit(0.1)
    with pytest.raises(ChangeError, match=f"{MAX_LABELS + 1} labels; it can have at most {MAX_LABELS}"):
        add_label(full, {"name": "one more"})
    with pytest.raises(ChangeError, match="can have at most"):
        adopt_labels(large, shipped_set("gtsrb-43"))
