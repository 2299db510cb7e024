"""No reader silently gives wrong boxes from a renumbered or truncated file, or from a file about another video.

The files are exports of ours, changed as other tools or accidents change them. An import passes if it is refused, or
reports something that the import of the unchanged file does not report, or gives exactly the right boxes. A table lists
the formats whose files cannot tell a reader, with the reason.
"""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from tests.exchange.small_datasets import GTSRB, make_track, make_video, target_of, write_grey_video
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Track
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS

WIDTH, HEIGHT, FRAMES = 64, 48, 16
PICTURES = ("cvat-images", "coco", "yolo", "voc", "gtsdb", "datumaro")
"""Formats that name pictures; what a number in a name means is theirs to find out."""

NAMES_NO_VIDEO = {"tracks-csv": "a table is called as its author likes, and our columns name no video"}
NAMES_NO_SIZE = {
    "yolo": "edges are shares of the picture",
    "label-studio": "edges are percent of the picture",
    "gtsdb": "rows have no size",
    "gtsrb": "the sizes are those of the crops",
    "tracks-csv": "our columns have no size",
}
SAYS_NO_LENGTH = {
    "cvat-images": "its size is the number of pictures that were exported",
    "coco": "it lists the pictures that were exported",
    "yolo": "it lists the pictures that were exported",
    "voc": "it lists the pictures that were exported",
    "datumaro": "it lists the pictures that were exported",
    "gtsdb": "it lists the pictures that were exported",
    "gtsrb": "it lists crops",
    "tracks-csv": "it lists boxes",
}
COUNTS_FROM_0 = {
    "cvat-video": "a frame is CVAT's own number from 0; nothing else in the file says where it counts from",
    "gtsrb": "crops.csv is ours, its frames count from 0",
    "tracks-csv": "these columns are ours, their frames count from 0",
    "tracks-json": "it says that it is ours (tsr-tracks), whose frames count from 0",
}
ROWS = ("yolo", "mot", "gtsrb", "gtsdb", "tracks-csv")
"""Formats of rows: cut between two of them, a file is a shorter one, as somebody may have meant it."""

Box = tuple[int, float, float, float, float, int]


@dataclass(frozen=True)
class Outcome:
    """Result of an import: boxes and report, or the sentence of the refusal."""

    boxes: list[Box]
    reported: tuple[str, ...]
    refused: str = ""

    def says_more_than(self, other: Outcome) -> bool:
        """Whether the report has a kind of sentence that the other report lacks."""
        return bool({_kind(sentence) for sentence in self.reported} - {_kind(sentence) for sentence in other.reported})


def _kind(sentence: str) -> str:
    return re.sub(r"[\d.]+", "#", sentence)


def _read(path: Path, video: DatasetVideo, name: str, **switches: str) -> Outcome:
    try:
        back = read_dataset(path, target_of(Dataset(GTSRB, (video,)), switches=switches), FORMATS[name])
    except ImportFormatError as error:
        return Outcome([], (), str(error))
    boxes = [
        (frame, *np.round(box, 2).tolist(), int(track.label if track.labels is None else track.labels[k]))
        for track in back.videos[0].tracks()
        for k, (frame, box) in enumerate(zip(track.frames.tolist(), track.boxes, strict=True))
    ]
    return Outcome(sorted(boxes), (*back.repaired, *(f"{left.what}: {left.reason}" for left in back.skipped)))


def _never_silent(found: Outcome, plain: Outcome, what: object = "") -> None:
    assert found.refused or found.says_more_than(plain) or found.boxes == plain.boxes, (what, found, plain)


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_grey_video(tmp_path_factory.mktemp("silent") / "drive.mp4", WIDTH, HEIGHT, FRAMES)


def _tracks(frames: Iterable[int], offset: tuple[float, float] = (0, 0)) -> list[Track]:
    """Two signs, the second in the last three frames only."""
    used = list(frames)
    x, y = offset
    return [
        make_track("m1", used, boxes=[(x + 4 + k, y + 5, x + 20 + k, y + 21) for k in range(len(used))]),
        make_track("h2", used[-3:], label=1, boxes=[(x + 30, y + 10 + k, x + 50, y + 30 + k) for k in range(3)]),
    ]


def _video(tracks: Iterable[Track] = (), clip: Path | None = None, **more: object) -> DatasetVideo:
    size = {"width": WIDTH, "height": HEIGHT} | {key: more.pop(key) for key in ("width", "height") if key in more}
    return replace(make_video(list(tracks), **{"frames": FRAMES, **more}), path=clip, **size)  # type: ignore[arg-type]


def _exported(name: str, out: Path, video: DatasetVideo, *, manifest: bool = False) -> Path:
    """The export as a folder without our manifest, which other tools do not keep."""
    pictures = "annotated" if FORMATS[name].needs_pictures else "none"
    options = ExportOptions(pictures=pictures, thin_px=0.0)
    export_dataset(Dataset(GTSRB, (video,)), FORMATS[name], out, options, zipped=False)
    if not manifest:
        (out / "manifest.json").unlink()
    return out


def _texts(folder: Path) -> list[Path]:
    return sorted(p for p in folder.rglob("*") if p.is_file() and p.suffix in (".xml", ".json", ".txt", ".csv"))


def _changed(folder: Path, change: Callable[[str], str], names: Callable[[str], str] = str) -> Path:
    """A copy of the folder with changed file contents and names."""
    for path in _texts(folder):
        path.write_text(change(path.read_text(encoding="utf-8")), encoding="utf-8")
        path.rename(path.with_name(names(path.name)))
    return folder


def _as_others_name(name: str, folder: Path, stem: str, shift: int = 0) -> Path:
    """Rename pictures to ``STEM000010``, move numbers by ``shift``, and drop what only our exports say about frames."""
    pattern = re.compile(r"\b(\d{5})(?=\.jpg)" if name == "gtsdb" else r"\bframe_(\d{6})")

    def renamed(text: str) -> str:
        return pattern.sub(lambda found: f"{stem}{int(found[1]) + shift:0{len(found[1])}d}", text)

    _changed(folder, renamed, renamed)
    for path in _texts(folder) if name in ("coco", "datumaro") else []:
        content = json.loads(path.read_text(encoding="utf-8"))
        for image in content.get("images", []):
            for key in set(image) - {"id", "file_name", "width", "height"}:
                del image[key]
        for item in content.get("items", []):
            item["attr"] = {}
        path.write_text(json.dumps(content), encoding="utf-8")
    if name == "cvat-images":
        _changed(folder, lambda text: re.sub(r"\s*<source>.*?</source>|\s*<name>drive</name>", "", text))
    return folder


def _shifted(name: str, folder: Path, by: int) -> Path:
    """Move all frame numbers of the file and of picture names."""
    if name in PICTURES:
        return _as_others_name(name, folder, "" if name == "gtsdb" else "frame_", by)

    def moved(text: str) -> str:
        if name == "cvat-video":
            return re.sub(r'frame="(\d+)"', lambda found: f'frame="{int(found[1]) + by}"', text)
        if name in ("label-studio", "tracks-json"):
            return re.sub(r'"frame":\s*(\d+)', lambda found: f'"frame":{int(found[1]) + by}', text)
        lines = text.split("\n")
        if name == "mot":
            rows = [re.sub(r"^\d+", lambda found: str(int(found[0]) + by), line) for line in lines]
            return "\n".join(rows) if text.count(",") > 5 * len(lines) - 10 and not text.startswith("id") else text
        header, *rows = (line.split(",") for line in lines)
        if "frame" not in header:
            return text
        at = header.index("frame")
        for row in rows:
            if len(row) > 1:
                row[at] = str(int(row[at]) + by)
        return "\n".join(",".join(row) for row in (header, *rows))

    return _changed(folder, moved)


def test_every_exemption_names_a_format() -> None:
    for table in (NAMES_NO_VIDEO, NAMES_NO_SIZE, SAYS_NO_LENGTH, COUNTS_FROM_0):
        assert set(table) < set(FORMATS)
    assert set(PICTURES) | set(ROWS) < set(FORMATS)


@pytest.mark.parametrize("name", list(FORMATS))
def test_our_export_of_another_video_is_refused(name: str, clip: Path, tmp_path: Path) -> None:
    out = _exported(name, tmp_path / "out", _video(_tracks(range(3, 9)), clip), manifest=True)
    found = _read(out, _video(name="other.mp4", sha="b" * 64), name)
    assert "is an export of drive.mp4, not of other.mp4" in found.refused
    again = _read(out, _video(sha="b" * 64), name)
    assert not again.refused, "the same drive, encoded again"


@pytest.mark.parametrize("name", [name for name in FORMATS if name not in NAMES_NO_VIDEO])
@pytest.mark.parametrize("other", ["other.mp4", "rear-drive.mp4", "drive2.mp4", "drive_2.mp4", "driv.mp4"])
def test_a_file_that_names_another_video_is_reported(name: str, other: str, clip: Path, tmp_path: Path) -> None:
    """The name is in ``<source>``, ``seqinfo.ini``, an address, or before the number of each picture."""
    out = _exported(name, tmp_path / "out", _video(_tracks(range(FRAMES)), clip))
    if name in PICTURES and name != "cvat-images":
        _as_others_name(name, out, "drive_")
    found = _read(out, _video(name=other, sha="b" * 64), name)
    assert "drive" in (found.refused + " ".join(found.reported)).replace(other, ""), found


@pytest.mark.parametrize("name", list(FORMATS))
def test_pictures_of_another_size_are_refused(name: str, clip: Path, tmp_path: Path) -> None:
    wide = 2 * WIDTH, 2 * HEIGHT
    big = write_grey_video(tmp_path / "big.mp4", *wide, FRAMES)
    inside = _video(_tracks(range(3, 9)), big, width=wide[0], height=wide[1])
    found = _read(_exported(name, tmp_path / "inside", inside), _video(), name)
    assert name in NAMES_NO_SIZE or f"{wide[0]}x{wide[1]}" in found.refused
    if name not in ("yolo", "label-studio"):
        # Boxes outside this video's picture are noticed even if the file states no size.
        beyond = _video(_tracks(range(3, 9), offset=(70, 50)), big, width=wide[0], height=wide[1])
        found = _read(_exported(name, tmp_path / "beyond", beyond), _video(), name)
        assert found.refused or "outside" in " ".join(found.reported)


@pytest.mark.parametrize("name", list(FORMATS))
def test_a_file_of_a_longer_video_is_reported(name: str, tmp_path: Path) -> None:
    long = write_grey_video(tmp_path / "long.mp4", WIDTH, HEIGHT, 2 * FRAMES)
    beyond = _video(_tracks(range(FRAMES - 6, FRAMES + 6)), long, frames=2 * FRAMES)
    found = _read(_exported(name, tmp_path / "beyond", beyond), _video(), name)
    assert found.refused or len(found.reported) > 1, found
    if name not in SAYS_NO_LENGTH:
        inside = _video(_tracks(range(3, 9)), long, frames=2 * FRAMES)
        plain = _read(_exported(name, tmp_path / "plain", _video(_tracks(range(3, 9)))), _video(), name)
        found = _read(_exported(name, tmp_path / "inside", inside), _video(), name)
        assert found.refused or found.says_more_than(plain), found


@pytest.mark.parametrize("name", list(FORMATS))
def test_frame_numbers_beyond_the_end_are_refused_or_corrected(name: str, clip: Path, tmp_path: Path) -> None:
    video = _video(_tracks(range(9, FRAMES)), clip)
    plain = _read(_exported(name, tmp_path / "plain", video), _video(), name)
    found = _read(_shifted(name, _exported(name, tmp_path / "moved", video), 1), _video(), name)
    assert found.refused or (found.boxes == plain.boxes and found.says_more_than(plain)), found


@pytest.mark.parametrize("name", [name for name in FORMATS if name not in (*PICTURES, *COUNTS_FROM_0)])
@pytest.mark.parametrize("by", [1, -1])
def test_ambiguous_frame_numbers_are_reported(name: str, by: int, clip: Path, tmp_path: Path) -> None:
    video = _video(_tracks(range(5, 11)), clip)
    found = _read(_shifted(name, _exported(name, tmp_path / "moved", video), by), _video(), name)
    assert found.refused or re.search(r"count|from [01]|first_frame|time", " ".join(found.reported)), found


@pytest.mark.parametrize("name", PICTURES)
@pytest.mark.parametrize("stem", ["", "img_", "drive_", "frame"])
@pytest.mark.parametrize("origin", [0, 1])
def test_pictures_whose_numbers_fit_both_counts(name: str, stem: str, origin: int, clip: Path, tmp_path: Path) -> None:
    video = _video(_tracks(range(3, 9)), clip)
    plain = _read(_exported(name, tmp_path / "plain", video), _video(), name)
    out = _as_others_name(name, _exported(name, tmp_path / "moved", video), stem, origin)
    found = _read(out, _video(), name)
    assert "first_frame" in found.refused + " ".join(found.reported), found
    assert _read(out, _video(), name, first_frame=str(origin)).boxes == plain.boxes


def _cut_positions(size: int, most: int = 24) -> list[int]:
    """Positions all over a file, and the last ones."""
    return sorted({*np.linspace(0, size - 1, most).astype(int).tolist(), *range(max(size - 8, 0), size)})


@pytest.mark.parametrize("beside", [True, False], ids=["ours", "bare"])
@pytest.mark.parametrize("name", list(FORMATS))
def test_a_truncated_file_is_never_silent(name: str, beside: bool, clip: Path, tmp_path: Path) -> None:
    """Also without the accompanying files that only we write."""
    out = _exported(name, tmp_path / "out", _video(_tracks(range(FRAMES - 4, FRAMES)), clip))
    track_files = [] if beside else [*out.rglob("tracks.csv"), *out.rglob("pictures.txt")]
    for path in track_files:
        path.unlink()
    plain = _read(out, _video(), name)
    assert plain.boxes
    files = [path for path in _texts(out) if path.name not in ("label_config.xml", "labels.txt", "labelmap.txt")]
    for path in files:
        whole = path.read_bytes()
        for cut in _cut_positions(len(whole)):
            if name in ROWS and b"\n" in whole[max(cut - 1, 0) : cut + 1]:
                continue
            path.write_bytes(whole[:cut])
            found = _read(out, _video(), name)
            if not (name in ROWS and cut == 0):
                _never_silent(found, plain, (path.name, cut, whole[max(cut - 60, 0) : cut]))
        path.write_bytes(whole)
    assert _read(out, _video(), name) == plain


@pytest.mark.parametrize("name", list(FORMATS))
def test_a_truncated_archive_is_refused(name: str, clip: Path, tmp_path: Path) -> None:
    out = _exported(name, tmp_path / "out", _video(_tracks(range(FRAMES - 4, FRAMES)), clip))
    packed = tmp_path / "out.zip"
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(out.rglob("*")):
            archive.write(path, path.relative_to(out))
    whole = packed.read_bytes()
    assert _read(packed, _video(), name).boxes
    for cut in _cut_positions(len(whole), 12)[1:]:
        packed.write_bytes(whole[:cut])
        assert _read(packed, _video(), name).refused, cut
