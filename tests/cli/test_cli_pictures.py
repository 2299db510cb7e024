"""`tsr detect` and `tsr classify` on still pictures, with toy parts."""

from __future__ import annotations

import json
import os
import signal
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

import tsr_engine.pipeline
from tests import toy_pipeline
from tsr_engine.cli import classify as classify_module
from tsr_engine.cli import detect as detect_module
from tsr_engine.cli.main import run
from tsr_engine.errors import InputError
from tsr_engine.io.models import Component, save_component
from tsr_engine.records import Detections, Picture

Capture = pytest.CaptureFixture[str]


@pytest.fixture(autouse=True)
def toy_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tsr_engine.pipeline, "load_components", toy_pipeline.load_components)
    monkeypatch.setattr(tsr_engine.pipeline, "load_reader", lambda *asked: toy_pipeline.HueClassifier())


@pytest.fixture
def scenes(tmp_path: Path) -> Path:
    folder = tmp_path / "scenes"
    folder.mkdir()
    for k in (0, 10, 11, 12, 20):
        cv2.imwrite(str(folder / f"{k:03d}.png"), toy_pipeline.drive_picture(k))
    return folder


def test_detect_writes_a_line_a_picture(scenes: Path, tmp_path: Path, capsys: Capture) -> None:
    assert run(["detect", str(scenes), "--jsonl", str(tmp_path / "o.jsonl")]) == 0
    lines = [json.loads(line) for line in (tmp_path / "o.jsonl").read_text().splitlines()]
    assert [line["image"] for line in lines] == ["000.png", "010.png", "011.png", "012.png", "020.png"]
    assert lines[0]["detections"] == []
    found = [d for line in lines for d in line["detections"]]
    assert found
    for line in lines[1:]:
        for d in line["detections"]:
            assert set(d) == {"x1", "y1", "x2", "y2", "score", "raw_score", "class_id", "class_prob"}
            drawn = toy_pipeline.sign_box(int(line["image"][:3]))
            assert abs(d["x1"] - drawn[0]) < 3
            assert abs(d["y2"] - drawn[3]) < 3
            assert d["score"] == pytest.approx(d["raw_score"] + 0.2, abs=1e-4)
            assert 0 < d["class_prob"] <= 1
    assert f"{len(found)} detections in 5 pictures" in capsys.readouterr().out


def test_detect_names_unreadable_pictures_and_continues(scenes: Path, tmp_path: Path, capsys: Capture) -> None:
    (scenes / "011.png").write_bytes(b"")
    (scenes / "012.png").write_bytes(b"\x89PNG\r\n\x1a\nbroken")
    assert run(["detect", str(scenes), "--jsonl", str(tmp_path / "o.jsonl")]) == 3
    captured = capsys.readouterr()
    assert "011.png is empty" in captured.err
    assert "012.png is not a picture" in captured.err
    assert "2 of 5 pictures could not be read" in captured.err
    assert "Traceback" not in captured.err
    assert len((tmp_path / "o.jsonl").read_text().splitlines()) == 3


def test_detect_finds_signs_of_no_class_beside_the_others(
    scenes: Path, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    requests = []

    class Others:
        def detect(self, picture: Picture, known: Detections) -> Detections:
            requests.append(len(known))
            return Detections(np.array([[5.0, 6, 35, 46]]), np.array([99.0]), np.array([0.5]), np.array([99.0]))

    monkeypatch.setattr(tsr_engine.pipeline, "load_other_shapes", lambda params, folder=None: Others())
    assert run(["detect", str(scenes), "--jsonl", str(tmp_path / "o.jsonl"), "--other-shapes"]) == 0
    lines = [json.loads(line)["detections"] for line in (tmp_path / "o.jsonl").read_text().splitlines()]
    places = {"x1": 5.0, "y1": 6.0, "x2": 35.0, "y2": 46.0, "score": 99.0, "raw_score": 99.0}
    assert [line[0] for line in lines] == [{**places, "class_id": -1, "class_prob": None}] * 5, "the best comes first"
    assert [len(line) - 1 for line in lines] == requests
    assert max(requests) > 0


def test_a_model_folder_without_other_shapes_is_named(scenes: Path, tmp_path: Path, capsys: Capture) -> None:
    models = tmp_path / "models"
    save_component(Component("classifier", {}), models)
    command = ["detect", str(scenes), "--jsonl", str(tmp_path / "o.jsonl"), "--other-shapes", "--models", str(models)]
    assert run(command) == 4
    assert "have no component 'other_shapes'" in capsys.readouterr().err


def test_detect_refuses_a_picture_bomb(tmp_path: Path, capsys: Capture) -> None:
    header = b"IHDR" + (60000).to_bytes(4, "big") * 2 + b"\x08\x02\x00\x00\x00"
    header += zlib.crc32(header).to_bytes(4, "big")
    (tmp_path / "bomb.png").write_bytes(b"\x89PNG\r\n\x1a\n\x00\x00\x00\r" + header + b"\0\0\0\x40IDAT" + b"\0" * 64)
    assert run(["detect", str(tmp_path / "bomb.png"), "--jsonl", str(tmp_path / "o.jsonl")]) == 3
    assert "bomb.png has more than the limit of 100000000 pixels" in capsys.readouterr().err


@pytest.mark.parametrize("with_json", [False, True])
def test_detect_keeps_the_lines_of_finished_pictures(
    scenes: Path, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch, with_json: bool
) -> None:
    seen = []
    real = detect_module.detections_of

    def interrupted(components: object, picture: object, others: object) -> list[dict[str, object]]:
        seen.append(1)
        if len(seen) == 3:
            os.kill(os.getpid(), signal.SIGINT)
        return real(components, picture, others)

    monkeypatch.setattr(detect_module, "detections_of", interrupted)
    (scenes / "000.png").write_bytes(b"")
    out = tmp_path / "o.jsonl"
    assert run(["detect", str(scenes), "--jsonl", str(out), *(["--json"] if with_json else [])]) == 130
    captured = capsys.readouterr()
    assert [json.loads(line)["image"] for line in out.read_text().splitlines()] == ["010.png", "011.png", "012.png"]
    assert "Interrupted. 4 of 5 pictures are done. 1 of 4 pictures could not be read" in captured.err
    assert "Traceback" not in captured.err
    if with_json:
        assert json.loads(captured.out)["interrupted"] is True


def test_detect_stops_among_unreadable_pictures(
    scenes: Path, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(path: Path) -> Picture:
        os.kill(os.getpid(), signal.SIGINT)
        raise InputError(f"{path.name} is empty.")

    monkeypatch.setattr("tsr_engine.io.pictures.read_picture", interrupted)
    assert run(["detect", str(scenes), "--jsonl", str(tmp_path / "o.jsonl")]) == 130
    assert "Interrupted. 1 of 5 pictures are done." in capsys.readouterr().err


def test_classify_keeps_the_rows_of_finished_crops(
    crops: Path, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Slow(toy_pipeline.HueClassifier):  # type: ignore[name-defined, misc]
        def probabilities(self, crops: object) -> object:
            os.kill(os.getpid(), signal.SIGINT)
            return super().probabilities(crops)

    monkeypatch.setattr(tsr_engine.pipeline, "load_reader", lambda *asked: Slow())
    monkeypatch.setattr(classify_module, "BATCH_SIZE", 4)
    out = tmp_path / "o.csv"
    assert run(["classify", str(crops), "--csv", str(out)]) == 130
    assert len(out.read_text().splitlines()) == 1 + 4
    assert f"Interrupted. 4 of 6 crops are done. See {out}." in capsys.readouterr().err


def test_detect_says_which_command_is_for_videos(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "drive.mp4").write_bytes(b"\0\0\0\x20ftypisom" + bytes(500))
    assert run(["detect", str(tmp_path / "drive.mp4"), "--jsonl", str(tmp_path / "o.jsonl")]) == 3
    assert "is a video, not a picture. Use `tsr track` for videos." in capsys.readouterr().err


@pytest.mark.parametrize("option", [["--onnx-size", "320x320"], ["--onnx-layout", "v5"]])
def test_an_option_of_a_network_needs_one(scenes: Path, tmp_path: Path, capsys: Capture, option: list[str]) -> None:
    assert run(["detect", str(scenes), "--jsonl", str(tmp_path / "o.jsonl"), *option]) == 2
    assert "Name its file with --onnx" in capsys.readouterr().err


def test_detect_never_overwrites_its_input(scenes: Path, capsys: Capture) -> None:
    picture = scenes / "010.png"
    before = picture.read_bytes()
    assert run(["detect", str(picture), "--jsonl", str(picture)]) == 2
    assert "is the input itself" in capsys.readouterr().err
    assert picture.read_bytes() == before
    assert run(["detect", str(scenes.parent / "none"), "--jsonl", "x"]) == 3


@pytest.fixture
def crops(tmp_path: Path) -> Path:
    """Two class folders in the benchmark's layout."""
    for class_id in (3, 14):
        folder = tmp_path / "gtsrb" / f"{class_id:05d}"
        folder.mkdir(parents=True)
        rows = ["Filename;Width;Height;Roi.X1;Roi.Y1;Roi.X2;Roi.Y2;ClassId"]
        for frame in range(3):
            picture = np.full((40, 40, 3), 60 + 40 * frame, np.uint8)
            picture[5:35, 5:35] = class_id
            cv2.imwrite(str(folder / f"00000_{frame:05d}.png"), picture)
            rows.append(f"00000_{frame:05d}.png;40;40;5;5;35;35;{class_id}")
        (folder / f"GT-{class_id:05d}.csv").write_text("\n".join(rows) + "\n")
    return tmp_path / "gtsrb"


def test_classify_class_folders(crops: Path, tmp_path: Path, capsys: Capture) -> None:
    assert run(["classify", str(crops), "--csv", str(tmp_path / "o.csv"), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    lines = (tmp_path / "o.csv").read_text().splitlines()
    assert lines[0] == "filename,class_id,probability"
    assert [line.split(",")[0] for line in lines[1:4]] == [f"00003/00000_{k:05d}.png" for k in range(3)]
    assert report["crops"] == report["labelled"] == 6
    right = sum(line.split(",")[0][:5].lstrip("0") == line.split(",")[1] for line in lines[1:])
    assert report["accuracy"] == pytest.approx(right / 6)
    assert all(0 < float(line.split(",")[2]) <= 1 for line in lines[1:])


@pytest.mark.parametrize(
    ("words", "reader", "said"),
    [
        ([], "both", ""),
        (["--reader", "classifier"], "classifier", ""),
        (["--network-classifier"], "network", "tsr: --network-classifier is now called --reader network. "),
    ],
)
def test_classify_uses_the_requested_reader(
    crops: Path,
    tmp_path: Path,
    capsys: Capture,
    monkeypatch: pytest.MonkeyPatch,
    words: list[str],
    reader: str,
    said: str,
) -> None:
    requests: list[object] = []

    def load(models: Path | None, reads: str) -> toy_pipeline.HueClassifier:
        requests.append(reads)
        return toy_pipeline.HueClassifier()

    monkeypatch.setattr(tsr_engine.pipeline, "load_reader", load)
    assert run(["classify", str(crops), "--csv", str(tmp_path / "o.csv"), *words]) == 0
    assert run(["eval", "classification", "--gtsrb", str(crops), *words]) == 0
    assert requests == [reader, reader]
    err = capsys.readouterr().err
    assert err.startswith(said)
    assert err.count("is now called") == (2 if said else 0)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--reader", "eye"], "--reader expects both, classifier or network. Got 'eye' instead."),
        (["--reader", "both", "--network-classifier"], "Set one of them, not both."),
    ],
)
def test_an_unknown_reader_is_refused(
    crops: Path, tmp_path: Path, capsys: Capture, words: list[str], said: str
) -> None:
    assert run(["classify", str(crops), "--csv", str(tmp_path / "o.csv"), *words]) == 2
    assert said in capsys.readouterr().err


def test_classify_a_test_table_uses_its_roi(crops: Path, tmp_path: Path) -> None:
    folder = crops / "00014"
    table = folder / "test.csv"
    table.write_text(
        "Filename;Width;Height;Roi.X1;Roi.Y1;Roi.X2;Roi.Y2\n00000_00002.png;40;40;10;10;30;30\n", encoding="utf-8"
    )
    assert run(["classify", str(table), "--csv", str(tmp_path / "o.csv")]) == 0
    name, class_id, _ = (tmp_path / "o.csv").read_text().splitlines()[1].split(",")
    assert (name, class_id) == ("00000_00002.png", "14")


def test_classify_escapes_names_that_are_not_utf8(tmp_path: Path) -> None:
    (tmp_path / "crops").mkdir()
    content = cv2.imencode(".png", np.full((40, 40, 3), 90, np.uint8))[1].tobytes()
    (tmp_path / "crops" / os.fsdecode(b"caf\xe9.png")).write_bytes(content)
    assert run(["classify", str(tmp_path / "crops"), "--csv", str(tmp_path / "o.csv")]) == 0
    assert (tmp_path / "o.csv").read_text().splitlines()[1].startswith("caf\\udce9.png,")


def test_classify_names_unreadable_crops_and_continues(crops: Path, tmp_path: Path, capsys: Capture) -> None:
    (crops / "00003" / "00000_00001.png").write_text("no picture")
    assert run(["classify", str(crops), "--csv", str(tmp_path / "o.csv")]) == 3
    err = capsys.readouterr().err
    assert "00000_00001.png is not a readable picture" in err
    assert "1 of 6 crops" in err
    assert len((tmp_path / "o.csv").read_text().splitlines()) == 6
