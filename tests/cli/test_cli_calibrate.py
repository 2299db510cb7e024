"""`tsr calibrate`: its output, and that the printed command works."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from tsr_engine.cli.main import run
from tsr_engine.evidence import EvidenceReader

Capture = pytest.CaptureFixture[str]
DRIVE = Path(__file__).parents[2] / "sample_videos" / "clips" / "low_sun.mp4"


@pytest.mark.parametrize("name", ["drive.mp4", "./-a drive.mp4"])
def test_the_printed_command_takes_over_the_focus(
    name: str, capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path(name).symlink_to(DRIVE)
    assert run(["calibrate", name, "--frames", "0:60"]) == 0
    output, command = capsys.readouterr().out.splitlines()
    assert "the focus of expansion lies at 0.44" in output
    assert "from 59 frames" in output
    words = shlex.split(command)
    assert words[0] == "tsr"
    assert run([*words[1:], "--frames", "0:3", "--csv", str(tmp_path / "rows.csv")]) == 0


def test_the_result_is_printed_as_json(capsys: Capture) -> None:
    assert run(["calibrate", str(DRIVE), "--frames", "100:140", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["coast_foe_y"] == pytest.approx(0.44, abs=0.02)
    assert 0.0 < found["error"] < 0.02
    assert found["frames"] == 39
    assert found["approach"] > 0.1


def stored_focus(folder: Path) -> float | None:
    with EvidenceReader(folder) as reader:
        return reader.header.parameters["tracking"]["coast_foe_y"]


def test_a_run_estimates_the_focus_from_its_video(capsys: Capture, tmp_path: Path) -> None:
    """The frames used do not depend on the tracked range: two ranges of a drive have one camera."""
    assert run(["calibrate", str(DRIVE), "--json"]) == 0
    y = round(json.loads(capsys.readouterr().out)["coast_foe_y"], 3)
    command = ["track", str(DRIVE), "--frames", "200:203", "--evidence", str(tmp_path / "run")]
    assert run(command) == 0
    assert f"focus of expansion lies at {y:.3f} of the picture's height (estimated from " in capsys.readouterr().out
    assert stored_focus(tmp_path / "run") == y
    assert run([*command, "--json"]) == 0  # resumes, here to its end, without a new estimate
    assert json.loads(capsys.readouterr().out)["focus"] is None
    assert run([*command, "--set", "tracking.coast_foe_y=0.5"]) == 5
    assert "coast_foe_y" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["--set", "coast_foe_y=0.61"], ["--preset", "paper"]])
def test_a_run_with_a_given_focus_or_without_the_option_estimates_nothing(
    words: list[str], capsys: Capture, tmp_path: Path
) -> None:
    assert run(["track", str(DRIVE), "--frames", "0:2", "--evidence", str(tmp_path / "run"), "--json", *words]) == 0
    assert json.loads(capsys.readouterr().out)["focus"] is None
    assert stored_focus(tmp_path / "run") == (0.61 if "--set" in words else None)


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["nothing.mp4"], 3, "There is no video at nothing.mp4"),
        ([str(DRIVE), "--frames", "9:9"], 2, "is empty"),
        ([str(DRIVE), "--frames", "0:2"], 3, "Choose --frames in which it drives"),
        ([str(DRIVE), "--frames", "900:"], 2, "900"),
        ([str(Path(__file__))], 3, "is not a video"),
    ],
)
def test_a_failed_estimate_is_one_sentence(words: list[str], code: int, said: str, capsys: Capture) -> None:
    assert run(["calibrate", *words]) == code
    out, err = capsys.readouterr()
    assert said in err
    assert out == ""
    assert "Traceback" not in err
