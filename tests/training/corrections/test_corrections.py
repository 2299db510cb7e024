"""Corrected tracks as training data: verdicts, chosen frames, and held-out videos."""

from __future__ import annotations

import json
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.training.corrected_tracks import make_track, make_video, write_video
from tsr_engine.errors import ImportFormatError, InputError
from tsr_engine.exchange.dataset import Dataset, Skipped
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.filters import Filters, filter_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.registry import format_named
from tsr_engine.io.gtsdb import Scene
from tsr_engine.labels.files import DEFAULT, shipped_set
from tsr_engine.training.corrections.corrected_scenes import (
    CorrectedScene,
    Sampling,
    corrected_scenes,
    is_reviewed,
    verdict,
)
from tsr_engine.training.corrections.exports import open_export
from tsr_engine.training.corrections.holdout import hold_out, regressions
from tsr_engine.training.corrections.retrain import Recipe, retrain


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"state": "accepted"}, "sign"),
        ({"state": "truth", "source": "truth"}, "sign"),
        ({"state": "open", "source": "human"}, "sign"),
        ({"state": "open", "source": "corrected"}, "sign"),
        ({"state": "open", "source": "engine"}, "unknown"),
        ({"state": "needs_work", "source": "human"}, "unknown"),
        ({"state": "accepted", "label": -1}, "unknown"),
        ({"state": "rejected", "source": "human"}, "rejected"),
    ],
)
def test_verdicts_follow_state_and_source(given: dict[str, object], expected: str) -> None:
    assert verdict(make_track(**given)) == expected


def test_an_unreviewed_video_gives_no_training_data(tmp_path: Path) -> None:
    open_track = make_track(state="open")
    assert not is_reviewed(make_video([open_track]))
    there = make_video([open_track], write_video(tmp_path / "a.mp4", [open_track]))
    assert corrected_scenes(Dataset(shipped_set(DEFAULT), (there,)), tmp_path / "work", Sampling()) == []


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> list[CorrectedScene]:
    folder = tmp_path_factory.mktemp("film")
    hidden = np.zeros(20, bool)
    hidden[10:] = True
    tracks = [
        make_track("m1", occluded=hidden),
        make_track("m2", 15, first=22, state="rejected"),
        make_track("m3", 40, side=8.0, grow=0.0, state="open"),
    ]
    there = make_video(tracks, write_video(folder / "a.mp4", tracks))
    return corrected_scenes(Dataset(shipped_set(DEFAULT), (there,)), folder / "work", Sampling(signs=5, background=4))


def test_frames_have_signs_rejected_and_ignored_places(scenes: list[CorrectedScene]) -> None:
    with_sign = [s for s in scenes if s.signs]
    assert {name for s in with_sign for name in s.signs} == {"toy.mp4/m1"}
    frames = {int(s.scene.name.split("#")[1]) for s in with_sign}
    assert frames <= set(range(10))  # not the occluded ones
    assert len(frames) >= 5
    assert max(frames) == 9
    assert all(len(s.scene.ignored) >= 1 for s in scenes)  # the open track is never background
    assert sum(len(s.rejected) for s in scenes) >= 5
    occluded = [s for s in scenes if 10 <= int(s.scene.name.split("#")[1]) < 20]
    assert all(len(s.scene.ignored) == 2 and not s.signs for s in occluded)
    for s in with_sign:
        np.testing.assert_array_equal(s.scene.occupied, np.concatenate([s.scene.boxes, s.scene.ignored]))


def test_places_of_signs_in_another_export_are_no_background(tmp_path: Path) -> None:
    one, two = make_track("m1"), make_track("m2", side=30.0)
    two = replace(two, boxes=two.boxes + np.array([0, 90, 0, 90]))
    path = write_video(tmp_path / "a.mp4", [one, two])
    videos = (make_video([one], path), make_video([one, two], path))
    found = corrected_scenes(Dataset(shipped_set(DEFAULT), videos), tmp_path / "work", Sampling(signs=4, background=4))
    of_first = [s for s in found if s.signs == ("toy.mp4/m1",)]
    assert of_first
    for s in of_first:
        np.testing.assert_array_equal(s.scene.ignored, two.boxes[[int(s.scene.name.split("#")[1])]])
    assert all(not len(s.scene.ignored) for s in found if len(s.signs) == 2), "it has both"


def test_pictures_are_decoded_once(tmp_path: Path) -> None:
    one = make_track()
    there = Dataset(shipped_set(DEFAULT), (make_video([one], write_video(tmp_path / "a.mp4", [one])),))
    reported: list[str] = []
    first = corrected_scenes(there, tmp_path / "work", Sampling(), lambda stage, *_: reported.append(stage))
    count = len(reported)
    assert count == len(first) > 5
    corrected_scenes(there, tmp_path / "work", Sampling(), lambda stage, *_: reported.append(stage))
    assert len(reported) == count


def test_a_too_short_video_is_reported(tmp_path: Path) -> None:
    short = write_video(tmp_path / "short.mp4", [], frames=3)
    with pytest.raises((InputError, Exception), match="3 frames|frame"):
        corrected_scenes(
            Dataset(shipped_set(DEFAULT), (make_video([make_track()], short),)), tmp_path / "work", Sampling()
        )


def _signs(scenes: list[CorrectedScene]) -> set[str]:
    return {name for scene in scenes for name in scene.signs}


def _three_videos(scenes: list[CorrectedScene]) -> list[CorrectedScene]:
    def of_video(scene: CorrectedScene, video: str) -> CorrectedScene:
        signs, rejected = (tuple(f"{video}/{n}" for n in names) for names in (scene.signs, scene.rejected_tracks))
        return replace(scene, video=video, signs=signs, rejected_tracks=rejected)

    return [of_video(scene, video) for video in "abc" for scene in scenes]


def test_too_many_signs_are_sampled_evenly_over_classes(tmp_path: Path) -> None:
    many = [make_track(f"m{k}", 8, first=k, label=2 if k else 5, side=20.0) for k in range(6)]
    there = Dataset(shipped_set(DEFAULT), (make_video(many, write_video(tmp_path / "a.mp4", many)),))
    for seed in range(3):
        found = corrected_scenes(there, tmp_path / f"w{seed}", Sampling(max_tracks=2), seed=seed)
        classes = [c for s in found for c in s.scene.class_ids]
        assert set(classes) == {2, 5}
        assert len(_signs(found)) == 2
        assert all(len(s.scene.occupied) >= 1 for s in found if s.signs)


def test_whole_videos_are_held_out_if_there_are_several(scenes: list[CorrectedScene]) -> None:
    every = _three_videos(scenes)
    holdout = hold_out(every, 4, 0.25)
    assert holdout.by == "video"
    assert len({s.video for s in holdout.held}) == 1
    assert not {s.video for s in holdout.held} & {s.video for s in holdout.training}
    assert _signs(holdout.held) | _signs(holdout.training) == _signs(every)
    assert hold_out(every, 4, 0.25).signs == holdout.signs


def test_videos_that_the_earlier_version_lacks_are_held_out_first(scenes: list[CorrectedScene]) -> None:
    every = _three_videos(scenes)
    for seed in range(6):
        assert {s.video for s in hold_out(every, seed, 0.25, learned={"a", "c"}).held} == {"b"}
    assert hold_out(every, 0, 0.25, learned={"a", "b", "c"}).signs == hold_out(every, 0, 0.25).signs


def test_signs_of_one_video_are_ignored_on_the_other_side(scenes: list[CorrectedScene]) -> None:
    two = [replace(s, signs=tuple(f"{n}{i % 2}" for n in s.signs)) for i, s in enumerate(scenes)]
    holdout = hold_out(two, 0, 0.25)
    assert holdout.by == "sign"
    assert len(holdout.signs) == 1
    assert _signs(holdout.held) == holdout.signs
    assert not _signs(holdout.training) & holdout.signs


def _rejected(scenes: list[CorrectedScene]) -> set[str]:
    return {name for scene in scenes for name in scene.rejected_tracks}


@pytest.mark.parametrize("given", [None, {"v/s1": "val", "v/r2": "test"}])
def test_rejected_tracks_of_one_video_are_ignored_on_the_other_side(given: dict[str, str] | None) -> None:
    def frame(number: int) -> CorrectedScene:
        boxes = np.array([[10.0 * k, 0.0, 10.0 * k + 9, 9.0] for k in range(6)])
        scene = Scene(f"v#{number}", Path("x.png"), boxes[:2], np.zeros(2, np.int64))
        return CorrectedScene(scene, "v", ("v/s0", "v/s1"), boxes[2:], tuple(f"v/r{k}" for k in range(4)))

    scenes = [frame(number) for number in range(3)]
    holdout = hold_out(scenes, 0, 0.25, given)
    assert len(_rejected(holdout.held)) == 1
    assert given is None or _rejected(holdout.held) == {"v/r2"}
    assert _rejected(holdout.training) == _rejected(scenes) - _rejected(holdout.held)
    for s in (*holdout.training, *holdout.held):
        assert len(s.rejected) == len(s.rejected_tracks)
        assert len(s.scene.ignored) == 6 - len(s.signs) - len(s.rejected_tracks)


def test_rejected_tracks_of_a_held_out_video_are_held_out(scenes: list[CorrectedScene]) -> None:
    holdout = hold_out(_three_videos(scenes), 4, 0.25)
    (video,) = {s.video for s in holdout.held}
    assert _rejected(holdout.held) == {f"{video}/toy.mp4/m2"}
    assert len(_rejected(holdout.training)) == 2


def test_the_split_of_an_export_is_kept_and_one_sign_is_never_held_out(scenes: list[CorrectedScene]) -> None:
    every = _three_videos(scenes)
    names = sorted(_signs(every))
    holdout = hold_out(every, 0, 0.25, {names[0]: "val", names[1]: "train", names[2]: "test"})
    assert (holdout.by, holdout.signs) == ("export", frozenset({names[0], names[2]}))
    assert _signs(holdout.held) == holdout.signs
    assert any(not s.signs for s in every)
    assert {s.video for s in holdout.training} == {"b"}, "the background of a held-out video is held out too"
    assert len(holdout.training) + len(holdout.held) == len(every)
    alone = hold_out(scenes, 0, 0.25)
    assert (alone.by, alone.held, alone.training) == ("none", [], scenes)


def test_regressions_are_reported() -> None:
    before = {"ap50": 0.9, "crops_right": 0.8, "mean_eq7": 0.1}
    assert regressions({"ap50": 0.897, "crops_right": 0.9, "mean_eq7": 0.1}, before, "Here") == []
    said = regressions({"ap50": 0.85, "crops_right": 0.8, "mean_eq7": 0.12}, before, "Here")
    assert said == [
        "Here: average precision at IoU 0.5 falls from 0.900 to 0.850.",
        "Here: the mean of Eq. 7 rises from 0.100 to 0.120.",
    ]


HARMLESS = (
    Skipped("2 attributes of tracks", "MOT has no place for them."),
    Skipped("toy.mp4: 3 boxes of 1 track", "They lie outside of frames 0 to 39, the only ones that were tracked."),
    Skipped("1 mark of occlusion", "Label Studio has no such mark."),
)
"""Losses that leave out no place."""


class TestExports:
    def export(self, folder: Path, pictures: str, zipped: bool, state: str = "accepted") -> tuple[Path, Path]:
        tracks = [make_track("m1", state=state), make_track("m2", 10, first=25, side=30.0, state=state)]
        path = write_video(folder / "toy.mp4", tracks)
        dataset = Dataset(shipped_set(DEFAULT), (replace(make_video(tracks, path), sha256="ab" * 32),))
        out = folder / ("export.zip" if zipped else "export")
        options = ExportOptions(pictures=pictures)
        export_dataset(dataset, format_named("cvat-video"), out, options, zipped=zipped, about={"states": [state]})
        return out, path

    def test_tracks_are_read_with_their_video(self, tmp_path: Path) -> None:
        out, path = self.export(tmp_path, "none", True)
        requests: list[str] = []

        def find(sha256: str, _name: str) -> Path:
            requests.append(sha256)
            return path

        opened = open_export(out, find, tmp_path)
        assert requests == ["ab" * 32]
        assert [verdict(t) for t in opened.dataset.videos[0].tracks()] == ["sign", "sign"]
        assert opened.about["format"] == "cvat-video"
        assert len(opened.about["sha256"]) == 64
        assert len(corrected_scenes(opened.dataset, tmp_path / "work", Sampling())) > 10

    def test_pictures_of_the_export_replace_the_video(self, tmp_path: Path) -> None:
        out, _ = self.export(tmp_path, "annotated", False)
        opened = open_export(out, lambda *_: None, tmp_path)
        assert set(opened.pictures[0]) == {*range(20), *range(25, 35)}
        found = corrected_scenes(opened.dataset, tmp_path / "work", Sampling(), None, opened.pictures)
        assert {s.scene.path.parent for s in found} == {p.parent for p in opened.pictures[0].values()}
        assert all(s.signs for s in found)

    def test_without_video_and_pictures_the_reason_is_reported(self, tmp_path: Path) -> None:
        out, _ = self.export(tmp_path, "none", False)
        opened = open_export(out, lambda *_: None, tmp_path)
        assert opened.dataset.videos == ()
        assert "is missing and the export has no pictures" in opened.notes[0]

    def test_an_export_of_unjudged_tracks_is_reported(self, tmp_path: Path) -> None:
        out, path = self.export(tmp_path, "none", False, "open")
        opened = open_export(out, lambda *_: path, tmp_path)
        assert "has no track that is marked as accepted" in opened.notes[0]
        with pytest.raises(InputError, match="Expected corrected signs to learn from.*has no track"):
            retrain([opened], Recipe(), None, tmp_path / "out", tmp_path / "work", lambda *_: None)
        assert not (tmp_path / "out").exists()

    @pytest.mark.parametrize("format", ["cvat-video", "yolo"])
    def test_places_of_tracks_that_are_left_out_are_no_background(self, format: str, tmp_path: Path) -> None:
        ignored = np.arange(20) < 5
        tracks = [
            make_track("m1", ignore=ignored),
            make_track("m2", 20, side=12.0, state="open"),
            make_track("m3", 5, first=30),
        ]
        tracks[1] = replace(tracks[1], boxes=tracks[1].boxes + np.array([0, 90, 0, 90]))
        path = write_video(tmp_path / "toy.mp4", tracks)
        whole = Dataset(shipped_set(DEFAULT), (replace(make_video(tracks, path), sha256="ab" * 32),))
        part = filter_dataset(whole, Filters(states=frozenset({"accepted"}), min_side=22.0, stop=25))
        about = {"states": ["accepted"]}
        options = ExportOptions(pictures="annotated")
        out = tmp_path / "export"
        chosen = format_named(format)
        export_dataset(part, chosen, out, options, zipped=False, about=about)
        opened = open_export(out, lambda *_: path, tmp_path)
        found = corrected_scenes(opened.dataset, tmp_path / "work", Sampling(signs=20, background=25))
        for s in found:
            k = int(s.scene.name.split("#")[1])
            unknown = [] if k >= 20 else [tracks[1].boxes[k], *([tracks[0].boxes[k]] if k < 5 else [])]
            np.testing.assert_allclose(
                np.sort(s.scene.ignored, axis=0), np.sort(np.array(unknown).reshape(-1, 4), axis=0), atol=0.06
            )
            assert bool(s.signs) == (5 <= k < 20)
        assert {int(s.scene.name.split("#")[1]) for s in found} == set(range(25))

    def test_an_export_of_an_earlier_version_is_reported_if_it_leaves_something_out(self, tmp_path: Path) -> None:
        tracks = [make_track("m1"), make_track("m2", 10, first=25, state="open")]
        path = write_video(tmp_path / "toy.mp4", tracks)
        whole = Dataset(shipped_set(DEFAULT), (replace(make_video(tracks, path), sha256="ab" * 32),))
        accepted = filter_dataset(whole, Filters(states=frozenset({"accepted"})))

        def notes(dataset: Dataset, earlier: bool, **asked: object) -> tuple[str, ...]:
            out = tmp_path / "export"
            export_dataset(dataset, format_named("cvat-video"), out, zipped=False, about=asked)
            content = json.loads((out / "manifest.json").read_text())
            if earlier:
                del content["videos"][0]["left_out"]
            (out / "manifest.json").write_text(json.dumps(content))
            return open_export(out, lambda *_: path, tmp_path, name="mine.zip").notes

        (note,) = notes(accepted, earlier=True)
        assert note.startswith("mine.zip: an earlier version of tsr made it without the places of what it leaves out")
        assert notes(whole, earlier=True, tracks={"run": ["m1"]}) == (note,)
        assert notes(accepted, earlier=False) == ()
        assert notes(whole, earlier=False) == ()
        assert notes(replace(whole, skipped=HARMLESS), earlier=True) == ()

    def test_damaged_places_are_refused(self, tmp_path: Path) -> None:
        out, path = self.export(tmp_path, "none", False)
        content = json.loads((out / "manifest.json").read_text())
        content["videos"][0]["left_out"] = [{"frames": [1, 2], "boxes": [[1, 2, 3, 4]]}]
        (out / "manifest.json").write_text(json.dumps(content))
        with pytest.raises(ImportFormatError, match="must list frames and as many boxes"):
            open_export(out, lambda *_: path, tmp_path)

    def test_other_folders_are_refused(self, tmp_path: Path) -> None:
        (tmp_path / "x.zip").write_text("nothing")
        with pytest.raises(ImportFormatError, match="expected an export folder or a ZIP"):
            open_export(tmp_path / "x.zip", lambda *_: None, tmp_path)
        with pytest.raises(ImportFormatError, match="not an export of this tool"):
            open_export(tmp_path, lambda *_: None, tmp_path)
        with pytest.raises(InputError, match="There is no export"):
            open_export(tmp_path / "nowhere", lambda *_: None, tmp_path)
        with zipfile.ZipFile(tmp_path / "bug.zip", "w") as archive:
            archive.writestr("manifest.json", '{"bundle": 1}')
        with pytest.raises(ImportFormatError, match=r"^.*bug\.zip: is not an export of this tool but another archive"):
            open_export(tmp_path / "bug.zip", lambda *_: None, tmp_path)
