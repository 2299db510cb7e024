"""The effect of labels on corrections, missing labels of a model, and contradictions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.training.corrected_tracks import draw_corrected_scenes, make_track, make_video, write_video
from tsr_engine.exchange.dataset import Dataset, Track
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.registry import format_named
from tsr_engine.exchange.relabel import unite_label_sets
from tsr_engine.labels.classes import default_keys
from tsr_engine.labels.files import shipped_set
from tsr_engine.labels.model import Label, LabelSet
from tsr_engine.training.corrections.class_mapping import drop_unseen_labels, map_to_classes, new_label_keys
from tsr_engine.training.corrections.corrected_scenes import Sampling, corrected_scenes, verdict
from tsr_engine.training.corrections.exports import OpenedExport, open_export

CUSTOM_SET = LabelSet(
    key="ours",
    name="Ours",
    next_id=60,
    labels=(
        Label(id=1, key="allj", name="Állj", aliases=("stop",)),
        Label(id=2, key="bus-stop", name="bus stop"),
        Label(id=3, key="bin", name="litter bin", teach="background"),
        Label(id=4, key="board", name="notice board", teach="ignore"),
        Label(id=5, key="old-stop", name="old stop", merged_into=1),
    ),
)


def opened(
    tracks: list[Track], labels: LabelSet = CUSTOM_SET, name: str = "a.zip", path: Path | None = None
) -> OpenedExport:
    return OpenedExport(Dataset(labels, (make_video(tracks, path),)), ({},), {}, {"name": name})


def result(exports: list[OpenedExport], keys: Any = None) -> list[dict[str, tuple[str, int]]]:
    """Verdict and class number of each track, by export."""
    return [
        {t.uid: (verdict(t), t.label) for t in export.dataset.videos[0].tracks()}
        for export in map_to_classes(exports, keys)
    ]


def separate_track(uid: str, place: int, **given: Any) -> Track:
    """Tracks that do not lie on each other."""
    made = make_track(uid, **given)
    return Track(**{**{n: getattr(made, n) for n in made.__dataclass_fields__}, "boxes": made.boxes + 300.0 * place})


def test_labels_decide_the_training_class() -> None:
    tracks = [separate_track(f"m{label}", label, label=label) for label in (1, 2, 3, 4, 5)]
    tracks += [separate_track("none", 6, label=-1), separate_track("open", 7, label=1, state="open")]
    tracks += [separate_track("away", 8, label=4, state="rejected")]
    (found,) = result([opened(tracks)])
    assert found == {
        "m1": ("sign", 14),
        "m2": ("unknown", -1),
        "m3": ("rejected", -1),
        "m4": ("unknown", -1),
        "m5": ("sign", 14),
        "none": ("unknown", -1),
        "open": ("unknown", 14),
        "away": ("rejected", -1),
    }


def test_labels_missing_from_the_model_are_named() -> None:
    tracks = [
        separate_track("m1", 0, label=2),
        separate_track("m2", 1, label=2),
        separate_track("m3", 2, label=1),
        separate_track("m4", 3, label=4),
    ]
    (export,) = map_to_classes([opened(tracks)], None)
    assert export.notes == (
        "a.zip: the model has no label for 'bus stop' (2 tracks). They are not used, neither as signs nor as "
        "background.",
    )
    assert result([opened(tracks)], ("x", "bus stop", "Stop")) == [
        {"m1": ("sign", 1), "m2": ("sign", 1), "m3": ("sign", 2), "m4": ("unknown", -1)}
    ]


def test_labels_missing_from_the_model_can_be_added() -> None:
    tracks = [
        separate_track("m1", 0, label=2),
        separate_track("m2", 1, label=1),
        separate_track("m3", 2, label=2, state="open"),
    ]
    exports = [opened(tracks), opened([separate_track("m4", 3, label=4), separate_track("m5", 4, label=3)])]
    assert new_label_keys(exports, None) == ("bus-stop",)
    assert new_label_keys(exports[1:], None) == new_label_keys(exports, (*default_keys(), "bus-stop")) == ()
    (found, _) = result(exports, (*default_keys(), *new_label_keys(exports, None)))
    assert (found["m1"], found["m2"]) == (("sign", 43), ("sign", 14))


def test_labels_without_a_frame_are_not_added(tmp_path: Path) -> None:
    scenes = draw_corrected_scenes(tmp_path, range(2), label=44)
    scenes, added = drop_unseen_labels(scenes, 43, ("bin", "bus-stop"))
    assert added == ("bus-stop",)
    assert {int(n) for scene in scenes for n in scene.scene.class_ids} == {43}


@pytest.mark.parametrize(
    ("other", "says"),
    [({"label": 2}, "'bus stop'"), ({"state": "rejected"}, "'no sign'"), ({"label": 3}, "'no sign'")],
)
def test_contradictions_are_named_and_not_used(other: dict[str, Any], says: str) -> None:
    one, two = make_track("m1", label=1), make_track("h2", label=1, first=5, frames=10)
    two = Track(**{**{n: getattr(two, n) for n in two.__dataclass_fields__}, **other, "boxes": one.boxes[5:15]})
    (export,) = map_to_classes([opened([one, two])], None)
    assert {verdict(t) for t in export.dataset.videos[0].tracks()} == {"unknown"}
    (note,) = export.notes
    assert note == (
        f"toy.mp4, frames 5 to 14: m1 says 'Állj', h2 says {says}. Neither of them teaches; correct one and export "
        "again."
    )


def test_two_exports_of_one_video_may_contradict_each_other() -> None:
    gtsrb = shipped_set("gtsrb-43")
    sets = ((1, CUSTOM_SET), (14, gtsrb), (13, gtsrb))
    one, same, other = (opened([make_track("m1", label=n)], labels, f"{n}.zip") for n, labels in sets)
    found = map_to_classes([one, other], None)
    assert [len(export.notes) for export in found] == [0, 1]
    assert "m1 says 'Állj', m1 says 'give way'" in found[1].notes[0]
    assert result([one, same]) == [{"m1": ("sign", 14)}, {"m1": ("unknown", -1)}], "one label by two names"
    assert [export.notes for export in map_to_classes([one, same], None)] == [(), ()]


def test_a_sign_of_two_exports_is_learned_once() -> None:
    """Under two names, it could be held out under one and learned under the other."""
    first, again = opened([make_track("m1", label=1)]), opened([make_track("7", label=1, frames=12)], name="b.zip")
    assert result([first, again]) == [{"m1": ("sign", 14)}, {"7": ("unknown", -1)}]
    rejected = [opened([make_track(uid, label=1, state="rejected")]) for uid in ("m1", "7")]
    assert result(rejected) == [{"m1": ("rejected", 14)}, {"7": ("unknown", -1)}]


def test_many_contradictions_are_counted() -> None:
    pairs = [(separate_track(f"m{k}", k, label=1), separate_track(f"h{k}", k, label=2)) for k in range(25)]
    (export,) = map_to_classes([opened([t for pair in pairs for t in pair])], None)
    assert len(export.notes) == 21
    assert export.notes[-1] == "5 more places are contradictory in the same way."


def test_an_ignored_region_is_neither_sign_nor_background(tmp_path: Path) -> None:
    every = np.ones(20, bool)
    tracks = [make_track("m1", label=14), separate_track("m2", 0, label=14, state="rejected", ignore=every, side=31.0)]
    assert verdict(tracks[1]) == "unknown"
    there = Dataset(shipped_set("gtsrb-43"), (make_video(tracks, write_video(tmp_path / "a.mp4", tracks)),))
    scenes = corrected_scenes(there, tmp_path / "work", Sampling(signs=4, background=4))
    assert sum(len(scene.rejected) for scene in scenes) == 0
    assert any(len(scene.scene.ignored) for scene in scenes)


def test_an_export_stores_merged_labels(tmp_path: Path) -> None:
    """The merged label's words may have become another label's, and a model may have its key."""
    stop = CUSTOM_SET.labels[0].model_copy(update={"aliases": ("stop", "old stop")})
    labels = CUSTOM_SET.model_copy(update={"labels": (stop, *CUSTOM_SET.labels[1:])})
    tracks = [make_track("m1", label=1)]
    path = write_video(tmp_path / "toy.mp4", tracks)
    out = tmp_path / "export"
    export_dataset(Dataset(labels, (make_video(tracks, path),)), format_named("cvat-video"), out, zipped=False)
    found = open_export(out, lambda *_: path, tmp_path)
    assert found.dataset.labels.resolved(5) == 1
    assert new_label_keys([found], ("x", "old-stop")) == ()
    assert result([found], ("x", "old-stop")) == [{"m1": ("sign", 1)}]


@pytest.mark.parametrize("newest_first", [False, True])
def test_exports_before_and_after_a_merge_teach_one_class(newest_first: bool) -> None:
    """The labels are not in the model, and the merged one's key is the later one, so both keys could become classes."""
    before = CUSTOM_SET.model_copy(
        update={"labels": (*CUSTOM_SET.labels[:4], CUSTOM_SET.labels[4].model_copy(update={"merged_into": None}))}
    )
    after = CUSTOM_SET.model_copy(update={"version": 2})
    exports = [opened([separate_track("m1", 0, label=5)], before), opened([separate_track("m2", 1, label=1)], after)]
    exports = exports[::-1] if newest_first else exports
    further = new_label_keys(exports, ("x",))
    assert further == ("allj",)
    found = result(exports, ("x", *further))
    assert sorted(one for each in found for one in each.items()) == [("m1", ("sign", 1)), ("m2", ("sign", 1))]


THEIRS = LabelSet(key="theirs", name="Theirs", next_id=9, labels=(Label(id=8, key="goal", name="goal"),))


def united_export(labels: LabelSet, uid: str, label: int) -> OpenedExport:
    """An export of two videos, of which only the first has a set that other exports have too."""
    videos = [(labels, [separate_track(uid, 1, label=label)]), (THEIRS, [separate_track("m9", 2, label=8)])]
    united, (first, second) = unite_label_sets([(each, make_video(tracks, None)) for each, tracks in videos])
    return OpenedExport(Dataset(united, (first, replace(second, sha256="b" * 64))), ({}, {}), {}, {"name": "b.zip"})


@pytest.mark.parametrize("united_first", [False, True], ids=["plain export from before", "united export from before"])
@pytest.mark.parametrize("target", ["allj", "halt"], ids=["into a known label", "into a later label"])
def test_an_export_of_two_label_sets_beside_one_of_another_version(united_first: bool, target: str) -> None:
    *known, old = CUSTOM_SET.labels
    before = CUSTOM_SET.model_copy(
        update={"version": 3, "labels": (*known, old.model_copy(update={"merged_into": None}))}
    )
    halt = Label(id=6, key="halt", name="Halt!")  # its number is that of another set's label in an older united export
    into = {"allj": 1, "halt": 6}[target]
    merged = old.model_copy(update={"merged_into": into})
    after = CUSTOM_SET.model_copy(update={"version": 4, "labels": (*known, merged, halt)})
    older, newer = ("m1", 5), ("m2", into)
    exports = (
        [united_export(before, *older), opened([separate_track(newer[0], 0, label=newer[1])], after)]
        if united_first
        else [opened([separate_track(older[0], 0, label=older[1])], before), united_export(after, *newer)]
    )
    further = new_label_keys(exports, ("x",))
    assert sorted(further) == sorted((target, "goal"))
    number = 1 + further.index(target)
    found = result(exports, ("x", *further))
    assert {**found[0], **found[1]} == {"m1": ("sign", number), "m2": ("sign", number)}


def test_label_sets_of_two_libraries_are_kept_apart() -> None:
    goal = Label(id=1, key="goal", name="goal")
    other = CUSTOM_SET.model_copy(update={"version": 9, "labels": (goal, *CUSTOM_SET.labels[1:4])})
    exports = [opened([separate_track("m1", 0, label=1)]), opened([separate_track("m2", 1, label=1)], other)]
    assert new_label_keys(exports, ("x",)) == ("allj", "goal")


def test_an_export_stores_the_training_classes_of_its_labels(tmp_path: Path) -> None:
    tracks = [separate_track("m1", 0, label=1), separate_track("m3", 0, first=22, frames=10, label=3)]
    path = write_video(tmp_path / "toy.mp4", tracks)
    out = tmp_path / "export"
    dataset = Dataset(CUSTOM_SET, (make_video(tracks, path),))
    options = ExportOptions(pictures="none")
    export_dataset(dataset, format_named("cvat-video"), out, options, zipped=False, about={"states": ["accepted"]})
    found = open_export(out, lambda *_: path, tmp_path)
    assert {label.key: label.teach for label in found.dataset.labels}["bin"] == "background"
    ((_, first), (_, second)) = sorted(result([found])[0].items())
    assert {first, second} == {("sign", 14), ("rejected", -1)}
