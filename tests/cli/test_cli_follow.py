"""`tsr follow`: rows, JSON lines, endings, and one sentence for each wrong box."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from tests.follow.synthetic_drives import HEIGHT, WIDTH, Drive, make_drive
from tsr_engine.cli.follow import COLUMNS
from tsr_engine.cli.main import run
from tsr_engine.geometry.boxes import iou_each

Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def synthetic_drive() -> Drive:
    return make_drive(frames=24, first=16.0, last=44.0)


@pytest.fixture(scope="module")
def video(synthetic_drive: Drive, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("follow") / "drive.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=Fraction(25))
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        stream.options = {"preset": "ultrafast", "crf": "14", "g": "10"}
        for picture in synthetic_drive.pictures:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="bgr24")))
        container.mux(stream.encode(None))
    return path


def box(synthetic_drive: Drive, frame: int) -> str:
    return f"{frame}," + ",".join(f"{v:.2f}" for v in synthetic_drive.boxes[frame])


def good(synthetic_drive: Drive, frame: int, edges: list[float]) -> bool:
    return float(iou_each(np.array(edges), synthetic_drive.boxes[frame])[0]) > 0.75


def test_rows_in_the_order_of_the_frames(synthetic_drive: Drive, video: Path, capsys: Capture, tmp_path: Path) -> None:
    out = tmp_path / "sign.csv"
    assert run(["follow", str(video), "--box", box(synthetic_drive, 12), "--csv", str(out)]) == 0
    output = capsys.readouterr().out
    assert output.startswith(f"{out}: 24 frames, 0 to 23. ")
    assert "The video ends with frame 23." in output
    assert "The video begins with frame 0." in output
    head, *rows = out.read_text().splitlines()
    assert head == COLUMNS == "frame,x1,y1,x2,y2,confidence,source"
    cells = [row.split(",") for row in rows]
    assert [int(c[0]) for c in cells] == list(range(24))
    assert all(good(synthetic_drive, int(c[0]), [float(v) for v in c[1:5]]) for c in cells)
    assert cells[12][5:] == ["1.0000", "anchor"]
    assert all(0.0 <= float(c[5]) <= 1.0 for c in cells)


def test_without_a_file_the_rows_are_printed(synthetic_drive: Drive, video: Path, capsys: Capture) -> None:
    assert run(["follow", str(video), "--box", box(synthetic_drive, 12), "--only", "backward"]) == 0
    out, err = capsys.readouterr()
    assert out.splitlines()[0] == COLUMNS
    assert len(out.splitlines()) == 14
    assert err == "tsr: The video begins with frame 0.\n"


def test_json_lines(synthetic_drive: Drive, video: Path, capsys: Capture) -> None:
    words = ["follow", str(video), "--box", box(synthetic_drive, 6), "--box", box(synthetic_drive, 18), "--json"]
    assert run(words) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    rows, endings = [v for v in lines if "source" in v], [v for v in lines if "reason" in v]
    assert [row["frame"] for row in rows] == list(range(24))
    assert [row["frame"] for row in rows if row["source"] == "anchor"] == [6, 18]
    assert all(good(synthetic_drive, row["frame"], [row[e] for e in ("x1", "y1", "x2", "y2")]) for row in rows)
    assert {e["direction"]: (e["frame"], e["reason"]) for e in endings} == {
        "forward": (23, "video"),
        "backward": (0, "video"),
    }


@pytest.mark.parametrize(
    ("boxes", "code", "said"),
    [
        (["5,500,10,560,60"], 2, "outside the picture of 480x320"),
        (["5,100,100,101,101"], 2, "too small"),
        (["5,nan,100,140,140"], 2, "finite"),
        (["5,140,100,100,140"], 2, "x1 < x2"),
        (["99,100,100,140,140"], 2, "no frame 99"),
        (["-1,100,100,140,140"], 2, "no frame -1"),
        (["5,100,100,140,140", "5,101,100,140,140"], 2, "two boxes"),
        (["5,100,100,140"], 2, "--box expects FRAME,x1,y1,x2,y2"),
        (["1.5,100,100,140,140"], 2, "--box expects"),
        (["five"], 2, "--box expects"),
    ],
)
def test_a_wrong_box_is_one_sentence(boxes: list[str], code: int, said: str, video: Path, capsys: Capture) -> None:
    words = [word for text in boxes for word in (f"--box={text}",)]
    assert run(["follow", str(video), *words]) == code
    out, err = capsys.readouterr()
    assert said in err
    assert len(err.splitlines()) == 1
    assert out == ""


def test_other_wrong_arguments(video: Path, capsys: Capture, tmp_path: Path) -> None:
    fine = "--box=5,100,100,140,140"
    for words, code, said in (
        ([str(tmp_path / "none.mp4"), fine], 3, "There is no video"),
        ([str(video), fine, "--only", "up"], 2, "forward or backward"),
        ([str(video), fine, "--csv", str(video)], 2, "input itself"),
        ([str(video), fine, "--models", str(tmp_path)], 4, ""),
        ([str(Path(__file__)), fine], 3, "is not a video"),
        ([str(video)], 2, "--box"),
    ):
        assert run(["follow", *words]) == code
        out, err = capsys.readouterr()
        assert said in err
        assert len(err.splitlines()) == 1
        assert out == ""
    assert video.stat().st_size > 1000
