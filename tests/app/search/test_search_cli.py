"""The command ``tsr search`` on a data folder."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from app.cli.main import run
from app.storage.models import Run
from tests.app.toy_home import ToyHome, make_home


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ToyHome]:
    home = make_home(tmp_path_factory.mktemp("search"))
    yield home
    home.evidence.close()
    home.database.close()


@pytest.fixture
def search(home: ToyHome) -> Callable[..., int]:
    """Run the command; returns its exit code."""
    return lambda *words: run(["search", "--home", str(home.settings.home), *words])


def test_the_command_reads_missing_runs_and_answers(
    search: Callable[..., int], capsys: pytest.CaptureFixture[str]
) -> None:
    assert search("--json", "--limit", "1") == 0
    answer = json.loads(capsys.readouterr().out)
    assert (answer["total"], len(answer["tracks"]), answer["unreadable"]) == (2, 1, [])
    assert answer["tracks"][0]["video_name"] == "drive.mp4"
    assert search("--rebuild") == 0
    captured = capsys.readouterr()
    assert "drive.mp4" in captured.out
    assert "2 tracks found." in captured.err + captured.out
    assert search("--state", "accepted") == 0
    assert "0 tracks found." in "".join(capsys.readouterr())


def test_the_command_names_the_labels_that_words_mean(
    search: Callable[..., int], capsys: pytest.CaptureFixture[str]
) -> None:
    assert search("--label", "end km", "--label", "Stop") == 0
    assert "Labels: end of speed limit 80 km/h, stop." in "".join(capsys.readouterr())
    assert search("--label", "Stop") == 0
    assert "Label" not in "".join(capsys.readouterr())


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--label", "unicorn"], "the key, name, alias or number 'unicorn'."),
        (["--state", "good"], "--state: "),
        (["--uncertainty-min", "3"], "--uncertainty-min: "),
        (["--since", "soon"], "Expected a day such as 2026-11-01"),
    ],
)
def test_a_wrong_value_is_one_sentence(
    search: Callable[..., int], words: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert search(*words) == 2
    error_output = capsys.readouterr().err
    assert sentence in error_output
    assert error_output.count("\n") == 1


def test_a_run_without_evidence_is_named(
    home: ToyHome, search: Callable[..., int], capsys: pytest.CaptureFixture[str]
) -> None:
    lost = home.add_run(name="Lost", kind="whatif")
    assert search("--all-runs") == 0
    captured = "".join(capsys.readouterr())
    assert "Lost of drive.mp4 cannot be read and is missing: " in captured
    with home.database.write() as session:
        session.delete(session.get_one(Run, lost))


def test_a_folder_without_a_library_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["search", "--home", str(tmp_path / "none")]) == 3
    assert "none" in capsys.readouterr().err
