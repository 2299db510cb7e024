"""MOT rows as trackers and benchmarks write them: ids, columns, classes and accompanying files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.exchange.image_datasets import write_text
from tests.exchange.small_datasets import make_dataset, target_of, tracks_of
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.added_labels import UnknownLabels
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS


def _read(path: Path, **switches: str) -> Dataset:
    return read_dataset(path, target_of(make_dataset(), switches=switches), FORMATS["mot"])


def _mot_rows(extra: str, *, id: str = "4", mark: str = ",", frames: range = range(11, 17)) -> str:
    """Rows of the box (110, 85, 40, 40), which moves by a pixel a frame; each row ends with ``extra``."""
    return "".join(
        f"{frame},{id},{99 + frame},85,40,40,{extra.split('|')[frame % (extra.count('|') + 1)]}\n" for frame in frames
    ).replace(",", mark)


def _write_sequence(folder: Path) -> None:
    """A sequence of stop signs."""
    write_text(folder, "gt/gt.txt", _mot_rows("1,1,1"))
    write_text(folder, "gt/labels.txt", "stop\n")


def _reports_only_count(dataset: Dataset) -> bool:
    """Whether the report says only that frames 11 to 16 may count from 0 as well."""
    return all("fit 0 and 1. Import with first_frame=0" in sentence for sentence in dataset.repaired)


def _reported(dataset: Dataset, *words: str) -> bool:
    return any(all(word in sentence for word in words) for sentence in dataset.repaired)


@pytest.mark.parametrize("mark", [",", ", ", " ", "   ", "\t", ";"])
@pytest.mark.parametrize("spelled", ["0.9,-1,-1,-1", "9.0e-01,-1.0e+00,-1.0e+00,-1.0e+00"])
def test_mot_is_recognised_with_every_separator(tmp_path: Path, mark: str, spelled: str) -> None:
    text = _mot_rows(spelled, mark=mark)
    if "e+" in spelled:
        text = "".join(f"{line[:2]}.0e+00{line[2:]}\n" for line in text.splitlines())
    found = read_dataset(write_text(tmp_path, "drive.txt", text), target_of(make_dataset()))
    (track,) = tracks_of(found).values()
    assert (track.frames.tolist(), track.boxes[0].tolist()) == (list(range(10, 16)), [110, 85, 150, 125])
    assert (track.score == 0.9).all()
    assert _reports_only_count(found)


def test_ids_above_the_whole_numbers_of_a_float(tmp_path: Path) -> None:
    rows = _mot_rows("1,1,1", id=str(2**53)) + _mot_rows("1,1,1", id=str(2**53 + 1), frames=range(40, 43))
    write_text(tmp_path, "gt/gt.txt", rows)
    write_text(tmp_path, "gt/labels.txt", "stop\n")
    found = tracks_of(_read(tmp_path))
    assert {uid: len(track.frames) for uid, track in found.items()} == {
        "track9007199254740992": 6,
        "track9007199254740993": 3,
    }


def test_polygons_of_yolo_are_not_mot(tmp_path: Path) -> None:
    path = write_text(tmp_path, "drive.txt", "0 0.1 0.1 0.2 0.1 0.2 0.2\n")
    assert not FORMATS["mot"].sniff(path)


def test_mot_ids_count_from_zero(tmp_path: Path) -> None:
    both = _mot_rows("0.9,-1,-1,-1", id="0") + _mot_rows("0.8,-1,-1,-1", id="1", frames=range(11, 13))
    found = _read(write_text(tmp_path, "drive.txt", both))
    assert {uid: len(track.frames) for uid, track in tracks_of(found).items()} == {"track0": 6, "track1": 2}
    assert _reports_only_count(found)
    none = _mot_rows("0.9,-1,-1,-1", id="-1")
    assert _reported(_read(write_text(tmp_path, "none.txt", none)), "6 boxes have no track id")
    twice = "1,0,10,10,20,20,1,-1,-1,-1\n1,0,200,10,20,20,1,-1,-1,-1\n"
    found = _read(write_text(tmp_path, "twice.txt", twice))
    assert len(tracks_of(found)) == 2, "id 0 twice in a frame is no id"


def test_visdrone_has_class_truncation_and_occlusion(tmp_path: Path) -> None:
    path = write_text(tmp_path, "drive.txt", _mot_rows("1,4,0,1|1,4,1,2|0,0,0,0"))
    found = read_dataset(path, target_of(make_dataset(), label_map={"car": 14}))
    (track,) = tracks_of(found).values()
    assert track.frames.tolist() == list(range(10, 16))
    assert np.isnan(track.score).all()
    assert track.occluded.tolist() == [False, False, True] * 2 or track.occluded.sum() == 2
    assert track.ignore is not None
    assert track.ignore.sum() == 2
    assert track.label == 14
    assert _reported(found, "column 8 was taken as the class of VisDrone", "column 10 as occlusion", "columns=results")
    plain = _read(path, columns="results")
    assert tracks_of(plain)["track4"].silent is not None
    with pytest.raises(ImportFormatError, match=r"drive.txt, line 1: has 10 columns, which columns=truth does not fit"):
        _read(path, columns="truth")


def test_ten_columns_with_a_list_of_classes(tmp_path: Path) -> None:
    write_text(tmp_path, "gt/gt.txt", _mot_rows("1,2,0,0"))
    write_text(tmp_path, "gt/labels.txt", "yield\nstop\n")
    found = _read(tmp_path)
    assert tracks_of(found)["track4"].label == 14
    assert not _reported(found, "VisDrone's list")


@pytest.mark.parametrize("extra", ["0.9,3.25,-1.5,0", "1,0,0,0", "0.5,7,8,9", "1,40,1,1"])
def test_world_coordinates_are_not_read_as_classes(tmp_path: Path, extra: str) -> None:
    found = _read(write_text(tmp_path, "det.txt", _mot_rows(extra)))
    (track,) = tracks_of(found).values()
    assert track.silent is not None
    assert track.score[0] == float(extra.split(",")[0])
    assert _reported(found, "Columns 8 to 10 were taken as positions", "columns=visdrone")


def test_results_of_visdrone_have_scores(tmp_path: Path) -> None:
    path = write_text(tmp_path, "drive.txt", _mot_rows("0.75,4,-1,-1"))
    with pytest.raises(UnknownLabels, match="'car'"):
        _read(path)
    found = read_dataset(path, target_of(make_dataset(), label_map={"car": -1}))
    assert (tracks_of(found)["track4"].score == 0.75).all()
    assert _reported(found, "column 8 was taken as the class of VisDrone's list", "column 7 as a score")


def test_boxmots_ninth_column_is_a_score(tmp_path: Path) -> None:
    path = write_text(tmp_path, "drive.txt", _mot_rows("1,0,0.412000|1,0,0.878290", id="100"))
    found = _read(path)
    track = tracks_of(found)["track100"]
    assert (track.label, track.score.min(), track.occluded.any()) == (0, 0.412, np.False_)
    assert _reported(found, "Column 9 was taken as a score", "columns=truth")
    assert _reported(found, "counted from 0 (first_class)", ": 6;")
    seen = _read(path, columns="truth", first_class="1")
    assert tracks_of(seen)["track100"].occluded.sum() == 3
    assert np.isnan(tracks_of(seen)["track100"].score).all()


@pytest.mark.parametrize(
    ("name", "extra", "hidden"),
    [
        ("gt.txt", "1,1,0.412|1,1,0.878", 3),
        ("drive/gt/gt.txt", "1,1,0.2", 6),
        ("drive/gt/gt.txt", "1,1,0", 6),
        ("drive.txt", "1,1,1|1,1,0.25", 3),
        ("drive.txt", "1,1,1|1,1,0", 3),
    ],
)
def test_low_visibility_is_reported(tmp_path: Path, name: str, extra: str, hidden: int) -> None:
    found = _read(write_text(tmp_path, name, _mot_rows(extra)))
    assert tracks_of(found)["track4"].occluded.sum() == hidden
    assert _reported(found, f"Column 9 was taken as the visibility, {hidden} boxes below 0.5", "columns=boxmot")


@pytest.mark.parametrize(
    ("number", "switch", "label"),
    [
        ("15", {}, 14),
        ("15", {"first_class": "0"}, 15),
        ("0", {}, 0),
        ("1", {"first_class": "1"}, 0),
        ("15", {"first_class": "1"}, 14),
    ],
)
def test_mot_classes_without_a_list_are_reported(
    tmp_path: Path, number: str, switch: dict[str, str], label: int
) -> None:
    found = _read(write_text(tmp_path, "gt.txt", _mot_rows(f"1,{number},1")), **switch)
    assert tracks_of(found)["track4"].label == label
    assert _reported(found, "Rows without labels.txt took their class number", "first_class")


@pytest.mark.parametrize("info", ["", "[Sequence]\n", "[Sequence]\nname=drive\nimDir=img1\nframeRate=25\nimExt=.jpg\n",
                                  "[Sequence]\nimWidth=\n", "[Other]\na=1\n"])  # fmt: skip
def test_a_sequence_without_size_is_not_checked(tmp_path: Path, info: str) -> None:
    _write_sequence(tmp_path)
    write_text(tmp_path, "seqinfo.ini", info)
    found = _read(tmp_path)
    assert (tracks_of(found)["track4"].frames.tolist(), _reports_only_count(found)) == (list(range(10, 16)), True)


def test_a_sequence_of_another_video_is_reported(tmp_path: Path) -> None:
    _write_sequence(tmp_path)
    write_text(tmp_path, "seqinfo.ini", "[Sequence]\nname=MOT17-02-FRCNN\nseqLength=600\nimWidth=640\nimHeight=360\n")
    found = _read(tmp_path)
    assert _reported(found, "seqinfo.ini: names MOT17-02-FRCNN", "drive.mp4")
    assert _reported(found, "its sequence has 600 frames, drive.mp4 has 100")
    write_text(tmp_path, "seqinfo.ini", "[Sequence]\nimWidth=many\n")
    with pytest.raises(ImportFormatError, match="seqinfo.ini.*whole numbers"):
        _read(tmp_path)


@pytest.mark.parametrize(
    ("name", "reported"),
    [("other/gt/gt.txt", True), ("drive/gt/gt.txt", False), ("MOT17-02/gt/gt.txt", False), ("train/gt/gt.txt", False)],
)
def test_a_folder_named_after_another_video_is_reported(tmp_path: Path, name: str, reported: bool) -> None:
    write_text(tmp_path, name, _mot_rows("1,1,1"))
    write_text(tmp_path, name.replace("gt.txt", "labels.txt"), "stop\n")
    assert _reported(_read(tmp_path), "names other", "drive.mp4") == reported
    assert not _reported(_read(tmp_path / name.split("/")[0]), "It was imported onto"), "a person chose the folder"
    (tmp_path / "readme.md").write_text("")
    assert _reported(_read(tmp_path), "names other", "drive.mp4") == reported


@pytest.mark.parametrize(
    ("name", "reported"),
    [
        ("other.txt", True),
        ("uav0000013.txt", True),
        ("drive.txt", False),
        ("det.txt", False),
        ("my_results.txt", False),
    ],
)
def test_a_file_named_after_another_video_is_reported(tmp_path: Path, name: str, reported: bool) -> None:
    assert _reported(_read(write_text(tmp_path, name, _mot_rows("0.9,-1,-1,-1"))), "names ") == reported


def test_sequences_of_other_videos_are_listed(tmp_path: Path) -> None:
    for name in ("drive", "other"):
        _write_sequence(tmp_path / name)
    found = _read(tmp_path)
    assert list(tracks_of(found)) == ["track4"]
    (left,) = found.skipped
    assert left.what.endswith(": 1 sequence")
    assert left.reason == "They are not about drive.mp4: other."


@pytest.mark.parametrize(
    ("frames", "reported"), [(range(1, 5), False), (range(2, 5), True), (range(2, 101), False), (range(1, 101), False)]
)
def test_frames_that_may_count_from_zero_are_reported(tmp_path: Path, frames: range, reported: bool) -> None:
    path = write_text(tmp_path, "gt.txt", _mot_rows("1,1,1", frames=frames))
    write_text(tmp_path, "labels.txt", "stop\n")
    found = _read(path)
    assert tracks_of(found)["track4"].frames[0] == frames[0] - 1
    assert (
        _reported(found, f"counted from 1, but the numbers {frames[0]} to {frames[-1]} fit 0 and 1", "first_frame=0")
        == reported
    )
    assert not _reported(_read(path, first_frame="1"), "fit 0 and 1")


def test_a_last_row_that_may_be_truncated_is_reported(tmp_path: Path) -> None:
    text = _mot_rows("1,1,1", frames=range(1, 4))
    assert _reported(
        _read(write_text(tmp_path, "gt.txt", text[:-1])), "without a line end after the last line", "gt.txt"
    )
    assert not _reported(_read(write_text(tmp_path, "gt.txt", text)), "without a line end after the last line")


def test_scores_beyond_one_may_be_left_out(tmp_path: Path) -> None:
    path = write_text(tmp_path, "det.txt", _mot_rows("0.5,-1,-1,-1|12.3,-1,-1,-1", id="-1", frames=range(1, 5)))
    with pytest.raises(ImportFormatError, match="det.txt, line 1: score 12.3 must be in 0 to 1.*scores=drop"):
        _read(path)
    found = _read(path, scores="drop")
    (track,) = tracks_of(found).values()
    assert np.isnan(track.score).tolist() == [True, False, True, False]
    assert _reported(found, "Scores outside 0 to 1 were left out: 2", "line 1")


def test_a_sequence_at_another_frame_rate_is_reported(tmp_path: Path) -> None:
    _write_sequence(tmp_path)
    for rate, reported in ((14, True), (24, True), (25, False)):
        write_text(tmp_path, "seqinfo.ini", f"[Sequence]\nframeRate={rate}\n")
        assert _reported(_read(tmp_path), f"says {rate} frames/s, drive.mp4 has 25") == reported
