"""The wheel is complete, and the base installation needs no extra."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from sample_videos import SHIPPED
from tsr_engine.extras import EXTRAS

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
IMPORTED_AS = {
    "psycopg": "psycopg", "pydantic-settings": "pydantic_settings", "rerun-sdk": "rerun", "scikit-learn": "sklearn",
}  # fmt: skip
BLOCKED = """
import importlib.abc, sys

class Blocked(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {names!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Blocked())
{code}
"""
"""Code in a process that has none of some packages."""
COMMAND = "from app.cli.main import run; sys.exit(run({arguments!r}))"


def package_name(requirement: str) -> str:
    return re.split(r"[\[<>=]", requirement)[0]


def run_without(packages: tuple[str, ...], code: str) -> subprocess.CompletedProcess[str]:
    whole = BLOCKED.format(names=set(packages), code=code)
    return subprocess.run([sys.executable, "-c", whole], capture_output=True, text=True, timeout=600, cwd=ROOT)


EVERYTHING = tuple(name for names in EXTRAS.values() for name in names)


@pytest.mark.parametrize(
    "arguments",
    [("--help",), ("doctor",), ("params",), ("track", str(SHIPPED[0].video), "--frames", "0:12")],
    ids=" ".join,
)
def test_the_base_needs_no_extra(arguments: tuple[str, ...]) -> None:
    done = run_without(EVERYTHING, COMMAND.format(arguments=[*arguments]))
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("extra", "arguments"),
    [
        ("review", ("review",)),
        ("review", ("models", "list", "--home", "nowhere")),
        ("review", ("export", "drive.mp4", "--format", "mot", "--out", "mot.zip")),
        ("train", ("eval", "tracking", ".", "--out", "report")),
        ("network", ("train", "network", "--gtsrb", ".", "--out", "models")),
    ],
)
def test_a_command_names_its_missing_extra(
    extra: str, arguments: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TSR_HOME", str(tmp_path))
    done = run_without(EXTRAS[extra], COMMAND.format(arguments=[*arguments]))
    assert done.returncode == 2
    assert re.fullmatch(rf"tsr: .* needs? \w+, which is not installed: pip install 'tsr\[{extra}\]'\.\n", done.stderr)


def test_the_server_starts_without_the_extras_beside_it() -> None:
    others = tuple(name for extra, names in EXTRAS.items() if extra != "review" for name in names)
    done = run_without(others, "import app.cli.serve, app.worker")
    assert done.returncode == 0, done.stderr


def test_extras_are_those_of_the_project() -> None:
    declared = PROJECT["optional-dependencies"]
    for extra, packages in EXTRAS.items():
        names = [package_name(requirement) for requirement in declared[extra]]
        assert {IMPORTED_AS.get(name, name) for name in names} <= set(packages), extra
    assert declared["all"] == [f"tsr[{','.join(extra for extra in EXTRAS if extra != 'network')}]"]
    assert "tsr[all]" in declared["dev"]


def test_nothing_of_the_base_belongs_to_an_extra() -> None:
    base = {re.split(r"[\[<>=]", requirement)[0] for requirement in PROJECT["dependencies"]}
    assert not base & {
        re.split(r"[\[<>=]", one)[0] for extra in EXTRAS for one in PROJECT["optional-dependencies"][extra]
    }


def test_the_wheel_contains_page_models_and_samples(tmp_path: Path) -> None:
    builder = pytest.importorskip("hatchling.builders.wheel")
    (wheel,) = builder.WheelBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"])
    with zipfile.ZipFile(wheel) as archive:
        held = set(archive.namelist())
        (metadata,) = (archive.read(name).decode() for name in held if name.endswith(".dist-info/METADATA"))
    page = {f"app/{path.relative_to(ROOT).as_posix()}" for path in (ROOT / "static").rglob("*") if path.is_file()}
    for folder in ("tsr_engine/models", "sample_videos/clips", "tsr_engine/labels/sets", "app/storage/migrations"):
        page |= {
            path.relative_to(ROOT).as_posix()
            for path in (ROOT / folder).rglob("*")
            if path.is_file() and "__pycache__" not in path.parts
        }
    assert page <= held
    assert {"tsr_engine/py.typed"} <= held
    assert not [name for name in held if name.startswith(("tests/", "benchmarks/"))]
    assert sorted(re.findall(r"^Provides-Extra: (\S+)$", metadata, re.M)) == sorted(PROJECT["optional-dependencies"])
