"""The contact sheet and its command."""

from __future__ import annotations

from pathlib import Path

import cv2
import pytest

from tsr_engine.pictograms.sheet import main, sheet

SMALL = ("--set", "gtsrb", "--size", "8")


def test_a_sheet_has_a_cell_for_each_drawing() -> None:
    picture = sheet(["gtsrb/14", "vienna/no-parking", "vienna/priority-for-oncoming-traffic"], 40, 2)
    assert picture.shape == (2 * (40 + 8 + 24), 2 * (40 + 8), 3)
    assert picture[24, 14].tolist() != [255, 255, 255]
    assert picture[72:, 48:].min() == 255  # an empty cell
    with pytest.raises(KeyError, match="vienna/nothing"):
        sheet(["vienna/nothing"])


def test_the_command_writes_png_and_webp(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for ending in ("png", "webp"):
        out = tmp_path / f"sheet.{ending}"
        main([str(out), "--set", "gtsrb", "--size", "16", "--columns", "10"])
        picture = cv2.imread(str(out))
        assert picture is not None
        assert picture.shape == (5 * 48, 10 * 24, 3)
    assert "43 drawings" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "reported"),
    [
        (["a.xyz", *SMALL], "must end in .png or .webp"),
        (["no/folder/a.png", *SMALL], "cannot be written"),
        (["a.png", "--set", "roman"], "invalid choice"),
        (["a.png", "--size", "0"], "at least 8"),
        ([], "required: out"),
    ],
)
def test_wrong_arguments_are_refused(
    arguments: list[str],
    reported: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit):
        main(arguments)
    assert reported in capsys.readouterr().err
