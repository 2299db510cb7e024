"""Every invalid input gives one sentence, its exit code, and no traceback."""

from __future__ import annotations

import json
import struct
import wave
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from tsr_engine.cli.main import refuse_empty_arguments, refuse_standard_output, run
from tsr_engine.io.models import Component, component_path, save_component

Capture = pytest.CaptureFixture[str]


def sentence(capsys: Capture, code: int, *arguments: object) -> str:
    got = run([str(a) for a in arguments])
    captured = capsys.readouterr()
    assert got == code, captured.err
    assert "Traceback" not in captured.err
    lines = captured.err.strip().splitlines()
    assert len(lines) == 1, captured.err
    assert lines[0].startswith("tsr: ")
    assert captured.out == ""
    return lines[0]


def write_video(path: Path, frames: int) -> Path:
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=Fraction(25))
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for k in range(frames):
            picture = np.full((48, 64, 3), (k * 9) % 255, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="bgr24")))
        container.mux(stream.encode(None))
    return path


def no_file(folder: Path) -> Path:
    return folder / "none.mp4"


def empty(folder: Path) -> Path:
    path = folder / "empty.mp4"
    path.touch()
    return path


def text(folder: Path) -> Path:
    path = folder / "text.mp4"
    path.write_text("#EXTM3U\n/etc/passwd\n")
    return path


def make_folder(folder: Path) -> Path:
    return folder


def truncated_video(folder: Path) -> Path:
    """The first half of an MP4, whose index is at its end."""
    whole = write_video(folder / "whole.mp4", 60).read_bytes()
    path = folder / "cut.mp4"
    path.write_bytes(whole[: len(whole) // 2])
    return path


def no_frames(folder: Path) -> Path:
    path = folder / "nothing.mkv"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=Fraction(25))
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        container.start_encoding()
    return path


def only_sound(folder: Path) -> Path:
    path = folder / "sound.m4a"
    with av.open(str(path), "w", format="mp4") as container:
        stream = container.add_stream("aac", rate=44100)
        samples = np.zeros((1, 1024), np.float32)
        for k in range(20):
            frame = av.AudioFrame.from_ndarray(samples, format="fltp", layout="mono")
            frame.sample_rate, frame.pts = 44100, k * 1024
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def wav_file(folder: Path) -> Path:
    path = folder / "sound.avi"
    with wave.open(str(path), "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(8000)
        out.writeframes(b"\0" * 1600)
    return path


def huge(folder: Path) -> Path:
    """A small file whose header announces pictures of 60000 x 60000."""
    path = write_video(folder / "small.mp4", 3)
    content = bytearray(path.read_bytes())
    old = struct.pack(">HH", 64, 48)
    at = content.index(b"avc1") + 28
    assert content[at : at + 4] == old
    content[at : at + 4] = struct.pack(">HH", 60000, 60000)
    path.write_bytes(bytes(content))
    return path


@pytest.mark.parametrize(
    "make",
    [no_file, empty, text, make_folder, truncated_video, no_frames, only_sound, wav_file],
    ids=lambda f: f.__name__,
)
@pytest.mark.parametrize("command", ["track"])
def test_bad_videos_are_refused(
    make: object, command: str, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    import tsr_engine.pipeline

    monkeypatch.setattr(tsr_engine.pipeline, "load_components", lambda params, folder=None, network=None: object())
    path = make(tmp_path)  # type: ignore[operator]
    got = sentence(capsys, 3, command, path, "--csv", tmp_path / "rows.csv", "--evidence", tmp_path / "run")
    assert path.name in got
    assert not (tmp_path / "rows.csv").exists()
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--set", "tau=nan"], "finite"),
        (["--set", "tau=-1"], "greater than 0"),
        (["--set", "tau=many"], "number"),
        (["--set", "tua=3"], "no parameter 'tua'"),
        (["--set", "tau"], "NAME=VALUE"),
        (["--set", "search_radius=2.5"], "search_radius"),
        (["--preset", "best"], "no preset 'best'"),
        (["--frames", "7"], "A:B"),
        (["--frames", "9:9"], "empty"),
        (["--frames", "-3:9"], "empty"),
        (["--colour"], "--colour"),
    ],
)
def test_bad_options_are_refused(arguments: list[str], words: str, capsys: Capture) -> None:
    assert words in sentence(capsys, 2, "track", "drive.mp4", *arguments)


def test_missing_argument_and_unknown_command(capsys: Capture) -> None:
    assert "VIDEO" in sentence(capsys, 2, "track")
    assert "No such command" in sentence(capsys, 2, "tarck")


@pytest.fixture
def video(tmp_path: Path) -> Path:
    return write_video(tmp_path / "ok.mp4", 5)


def test_missing_models_are_reported(video: Path, tmp_path: Path, capsys: Capture) -> None:
    got = sentence(capsys, 4, "track", video, "--models", tmp_path / "nowhere")
    assert "There are no models" in got


def test_models_of_another_format(video: Path, tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "manifest.json").write_text(json.dumps({"format": 99, "components": {}}))
    assert "format 99" in sentence(capsys, 4, "track", video, "--models", tmp_path / "models")


def test_models_with_a_wrong_hash(video: Path, tmp_path: Path, capsys: Capture) -> None:
    models = tmp_path / "models"
    for name in ("detector", "classifier"):
        save_component(Component(name, {"a": np.zeros(3)}), models)
    component_path("detector", models).write_bytes(b"something else")
    assert "sha256" in sentence(capsys, 4, "track", video, "--models", models)
    assert "sha256" in sentence(capsys, 4, "detect", video, "--jsonl", tmp_path / "o.jsonl", "--models", models)


def test_models_with_arrays_of_something_else(video: Path, tmp_path: Path, capsys: Capture) -> None:
    for name in ("detector", "classifier"):
        save_component(Component(name, {"a": np.zeros(3)}), tmp_path / "models")
    assert "tsr train" in sentence(capsys, 4, "track", video, "--models", tmp_path / "models")


def test_replay_of_a_folder_without_evidence(tmp_path: Path, capsys: Capture) -> None:
    assert "run.json is missing" in sentence(capsys, 5, "replay", tmp_path)
    (tmp_path / "run.json").write_text("{")
    assert "damaged" in sentence(capsys, 5, "replay", tmp_path)


def test_unexpected_failure_is_one_sentence(video: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    import tsr_engine.pipeline

    def broken(params: object, folder: object = None, network: object = None) -> object:
        raise RuntimeError("the parts do not fit\nsecond line")

    monkeypatch.setattr(tsr_engine.pipeline, "load_components", broken)
    got = sentence(capsys, 1, "track", video)
    assert "the parts do not fit" in got
    assert "TSR_TRACEBACK=1" in got
    monkeypatch.setenv("TSR_TRACEBACK", "1")
    assert run(["track", str(video)]) == 1
    assert "Traceback" in capsys.readouterr().err


def test_missing_training_data_are_reported(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "models"
    assert "class folders" in sentence(capsys, 3, "train", "classifier", "--gtsrb", tmp_path, "--out", out)
    assert "--gtsdb" in sentence(capsys, 2, "train", "detector", "--out", out)
    assert "--signs" in sentence(capsys, 2, "train", "other-shapes", "--gtsdb", tmp_path, "--out", out)
    signs = ("--signs", tmp_path / "signs.json")
    assert "--gtsdb" in sentence(capsys, 2, "train", "other-shapes", *signs, "--out", out)
    assert "--export" in sentence(capsys, 2, "train", "detector", *signs, "--export", tmp_path, "--out", out)
    assert not out.exists()


@pytest.mark.parametrize(
    "command",
    [
        "train all --gtsdb {data} --gtsrb {data}",
        "train detector --export {data}",
        "eval detection --gtsdb {data}",
        "eval classification --gtsrb {data}",
        "eval fusion --gtsrb {data}",
        "eval tracking {data}",
    ],
)
def test_an_impossible_output_folder_is_refused_before_the_work(command: str, tmp_path: Path, capsys: Capture) -> None:
    """The data are invalid too; the folder must be reported first."""
    (tmp_path / "file").write_text("x")
    (tmp_path / "data").mkdir()
    words = command.format(data=tmp_path / "data").split()
    assert "a file stands where a folder is needed" in sentence(capsys, 6, *words, "--out", tmp_path / "file" / "out")
    assert "a file stands where a folder is needed" in sentence(capsys, 6, *words, "--out", tmp_path / "file")
    assert sentence(capsys, 3, *words, "--out", tmp_path / "out")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["data", "file"]


def test_unextendable_models_are_refused_before_the_work(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "manifest.json").write_text("{")
    assert sentence(capsys, 4, "train", "classifier", "--gtsrb", tmp_path, "--out", tmp_path)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["track", "drive.mp4", "--evidence", ""], "The value of --evidence is empty"),
        (["track", "drive.mp4", "--evidence="], "The value of --evidence is empty"),
        (["track", ""], "A word of the command is empty"),
        (["detect", "a.png", "", "--jsonl", "o"], "A word of the command is empty"),
    ],
)
def test_an_empty_path_is_not_the_current_folder(capsys: Capture, arguments: list[str], named: str) -> None:
    assert named in sentence(capsys, 2, *arguments)


@pytest.mark.parametrize("words", [["track", "drive.mp4", "--csv", "-"], ["sample", "--out=-"]])
def test_standard_output_is_no_output(
    words: list[str], tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert "cannot write to standard output" in sentence(capsys, 2, *words)
    assert list(tmp_path.iterdir()) == []
    refuse_standard_output(["bundle", "run", "--note", "-", "--out", "./-"])


def test_free_text_may_be_empty() -> None:
    refuse_empty_arguments(["bundle", "run", "--note", "", "--out", "b.zip"])
    refuse_empty_arguments(["bundle", "run", "--note=", "--out=b.zip", "--set", "tau=3"])
    refuse_empty_arguments([])


@pytest.mark.parametrize("command", [["detect", "--jsonl", "o.jsonl"], ["classify", "--csv", "o.csv"]])
def test_paths_that_cannot_be_looked_at(
    command: list[str], tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert "File name too long. Check the path" in sentence(capsys, 3, *command, "n" * 300)
    (tmp_path / "a.png").touch()
    assert "File name too long. Check the path" in sentence(capsys, 3, *command[:-1], "n" * 300, tmp_path)
