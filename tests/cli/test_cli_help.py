"""The help texts of the command line."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from tsr_engine.cli.main import run
from tsr_engine.params import Params
from tsr_engine.version import __version__

Capture = pytest.CaptureFixture[str]
COMMANDS = (
    "track", "detect", "classify", "train", "eval", "replay", "follow", "calibrate", "sample", "params", "doctor",
)  # fmt: skip
LEAVES = (
    "track", "detect", "classify", "train detector", "train prior", "train classifier", "train online", "train all",
    "eval detection", "eval classification", "eval fusion", "eval tracking", "replay", "follow", "calibrate", "sample",
    "params", "doctor",
)  # fmt: skip


def test_help_lists_every_command_and_the_exit_codes(capsys: Capture) -> None:
    assert run(["--help"]) == 0
    out = capsys.readouterr().out
    assert [name for name in COMMANDS if f"\n  {name} " not in out] == []
    assert "Exit codes" in out


@pytest.mark.parametrize("command", LEAVES)
def test_help_of_every_command_has_an_example(command: str, capsys: Capture) -> None:
    assert run([*command.split(), "--help"]) == 0
    out = capsys.readouterr().out
    assert "Example" in out
    assert f"tsr {command}" in out.split("Example")[1]


@pytest.mark.parametrize("command", ["network", "memory", "other-shapes"])
def test_help_of_training_without_corrections_does_not_mention_them(command: str, capsys: Capture) -> None:
    assert run(["train", command, "--help"]) == 0
    assert "--export" not in capsys.readouterr().out


@pytest.mark.parametrize("command", ["track", "replay", "detect"])
def test_help_lists_every_parameter_with_its_range(command: str, capsys: Capture) -> None:
    assert run([command, "--help"]) == 0
    out = capsys.readouterr().out
    assert [leaf for _, leaf in Params.names() if f"\n  {leaf} = " not in out] == []
    assert "tau = 15.0  (0, " in out


def test_params_as_json(capsys: Capture) -> None:
    assert run(["params", "--preset", "paper", "--json"]) == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)}
    assert rows["motion"]["value"] == "paper"
    assert len(rows) == len(list(Params.names()))


def test_version(capsys: Capture) -> None:
    assert run(["--version"]) == 0
    assert capsys.readouterr().out.strip() == f"tsr {__version__}"


def test_help_does_not_import_the_heavy_libraries() -> None:
    code = (
        "import sys\nfrom tsr_engine.cli.main import run\nrun(['--help'])\n"
        "heavy = {'cv2', 'numba', 'scipy', 'sklearn', 'av', 'pydantic', 'matplotlib'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
