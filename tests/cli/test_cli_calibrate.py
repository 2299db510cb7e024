"""`tsr calibrate`: what it prints, and that it runs as it says."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from tsr_engine.cli.main import run
from tsr_engine.evidence import EvidenceReader

Capture = pytest.CaptureFixture[str]
DRIVE = Path(__file__).parents[2] / "sample_videos" / "clips" / "low_sun.mp4"


def test_the_printed_command_takes_over_the_focus(capsys: Capture, tmp_path: Path) -> None:
    assert run(["calibrate", str(DRIVE), "--frames", "0:60"]) == 0
    said, command = capsys.readouterr().out.splitlines()
    assert "the focus of expansion lies at 0.44" in said
    assert "from 59 frames" in said
    words = shlex.split(command)
    assert words[0] == "tsr"
    assert run([*words[1:], "--frames", "0:3", "--csv", str(tmp_path / "rows.csv")]) == 0


def test_as_json(capsys: Capture) -> None:
    assert run(["calibrate", str(DRIVE), "--frames", "100:140", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["foe_y"] == pytest.approx(0.44, abs=0.02)
    assert 0.0 < found["error"] < 0.02
    assert found["frames"] == 39
    assert found["approach"] > 0.1


def test_a_run_calibrates_itself(capsys: Capture, tmp_path: Path) -> None:
    assert run(["calibrate", str(DRIVE), "--frames", "0:30", "--json"]) == 0
    y = round(json.loads(capsys.readouterr().out)["foe_y"], 3)
    command = ["track", str(DRIVE), "--calibrate", "--frames", "0:30", "--evidence", str(tmp_path / "run")]
    assert run(command) == 0
    assert f"Calibrated: --set foe_y={y}" in capsys.readouterr().err
    with EvidenceReader(tmp_path / "run") as reader:
        assert reader.header.parameters["tracking"]["foe_y"] == y
    assert run(command) == 0  # the same focus: the run goes on, here to its end
    assert run([*command, "--set", "tracking.foe_y=0.5"]) == 2
    assert "Choose one of them" in capsys.readouterr().err


def test_a_car_that_stands_is_tracked_all_the_same(capsys: Capture, tmp_path: Path) -> None:
    assert run(["track", str(DRIVE), "--calibrate", "--frames", "0:2", "--csv", str(tmp_path / "rows.csv")]) == 0
    assert "taken to lie at foe_y = 0.5" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["nothing.mp4"], 3, "There is no video at nothing.mp4"),
        ([str(DRIVE), "--frames", "9:9"], 2, "is empty"),
        ([str(DRIVE), "--frames", "0:2"], 3, "Choose --frames in which it drives on"),
        ([str(DRIVE), "--frames", "900:"], 2, "900"),
        ([str(Path(__file__))], 3, "is not a video"),
    ],
)
def test_what_cannot_be_told_is_one_sentence(words: list[str], code: int, said: str, capsys: Capture) -> None:
    assert run(["calibrate", *words]) == code
    out, err = capsys.readouterr()
    assert said in err
    assert out == ""
    assert "Traceback" not in err
