"""`python -m app` knows every command of `tsr`, `python -m tsr_engine` only the engine's."""

from __future__ import annotations

import subprocess
import sys

import pytest

REVIEW = ("review", "export", "import", "formats", "bundle", "record", "models")


def _reported(module: str, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", module, *words], capture_output=True, text=True, timeout=120, check=False
    )


def test_the_application_has_all_commands() -> None:
    reported = _reported("app", "--help")
    assert reported.returncode == 0
    commands = {line.split()[0] for line in reported.stdout.partition("Commands:")[2].splitlines() if line[2:3].strip()}
    assert commands > {"track", "replay", "train", *REVIEW}


@pytest.mark.parametrize("command", REVIEW)
def test_the_engine_alone_refuses_commands_of_the_review_tool(command: str) -> None:
    reported = _reported("tsr_engine", command)
    assert reported.returncode == 2
    assert f"No such command '{command}'" in reported.stderr
    assert "`tsr` and `python -m app` also have the commands of the review tool." in reported.stderr
    assert reported.stderr.count("\n") == 1


@pytest.mark.parametrize(("module", "words"), [("app", ("exprot",)), ("tsr_engine", ("train", "export"))])
def test_other_unknown_commands_do_not_lead_to_the_review_tool(module: str, words: tuple[str, ...]) -> None:
    reported = _reported(module, *words)
    assert reported.returncode == 2
    assert "No such command" in reported.stderr
    assert "review tool" not in reported.stderr
