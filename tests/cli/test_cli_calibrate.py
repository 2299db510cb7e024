"""`tsr calibrate`: what it prints, and that it runs as it says."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from tsr_engine.cli.main import run

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
