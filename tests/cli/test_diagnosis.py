"""`tsr doctor` lists what is installed, and how to install what is missing."""

from __future__ import annotations

import importlib.metadata
import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tsr_engine.cli import diagnosis
from tsr_engine.cli.diagnosis import Check, diagnose
from tsr_engine.io.models import Component, component_path, save_component


def by_name(checks: list[Check]) -> dict[str, Check]:
    return {check.name: check for check in checks}


@pytest.fixture
def models(tmp_path: Path) -> Path:
    for name in ("detector", "prior", "classifier"):
        save_component(Component(name, {"w": np.arange(4.0)}), tmp_path / "models")
    return tmp_path / "models"


def test_a_complete_installation_is_ok(models: Path) -> None:
    checks = by_name(diagnose(models))
    for name in ("python", "tsr", "av", "numba", "numpy", "opencv-python-headless", "scipy", "h264 (decode)", "cores"):
        assert checks[name].status == "ok"
        assert checks[name].found
    for name in ("model detector", "model prior", "model classifier"):
        assert checks[name].status == "ok"
        assert "sha256" in checks[name].found
    assert not any(check.status == "missing" for check in checks.values())


def test_every_problem_comes_with_advice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(diagnosis, "CODECS", (("no_such_codec", "r", "missing"),))
    monkeypatch.setattr(diagnosis, "MIN_MEMORY_GIB", 1e9)
    checks = diagnose(tmp_path / "absent")
    bad = [check for check in checks if check.status != "ok"]
    assert {check.name for check in bad} >= {"no_such_codec (decode)", "models"}
    assert all(check.advice for check in bad)
    # the package of this name on the index is another project
    assert not [check.advice for check in bad if re.search(r"pip install( --\S+)* tsr\b", check.advice)]


def test_missing_and_old_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        importlib.metadata, "requires", lambda _: ["numpy>=999.0", "no-such-package>=1.0", "pytest>=1 ; extra == 'dev'"]
    )
    checks = by_name(diagnose())
    assert checks["numpy"].status == "missing"
    assert "older than 999.0" in checks["numpy"].found
    assert checks["no-such-package"].found == "not installed"
    assert checks["no-such-package"].advice == 'pip install "no-such-package>=1.0"'
    assert "pytest" not in checks


def test_an_old_python_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    class Version(tuple):  # type: ignore[type-arg]
        __slots__ = ()

    monkeypatch.setattr(diagnosis, "sys", SimpleNamespace(version_info=Version((3, 9, 1))))
    assert by_name(diagnose())["python"].status == "missing"


def test_a_changed_model_is_found(models: Path) -> None:
    changed = component_path("prior", models)
    content = bytearray(changed.read_bytes())
    content[-1] ^= 1
    changed.write_bytes(content)
    component_path("detector", models).unlink()
    checks = by_name(diagnose(models))
    assert checks["model prior"].status == "missing"
    assert "does not match its manifest" in checks["model prior"].found
    assert checks["model detector"].status == "missing"
    assert checks["model classifier"].status == "ok"


def test_a_cache_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "file"
    file.touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(file))
    check = by_name(diagnose())["compiled code cache"]
    assert check.status == "warning"
    assert "NUMBA_CACHE_DIR" in check.advice
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "new" / "folder"))
    assert by_name(diagnose())["compiled code cache"].status == "ok"
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.setenv(name, str(file))
    monkeypatch.setattr(diagnosis, "SHIPPED", file / "models")
    check = by_name(diagnose())["compiled code cache"]
    assert (check.status, "NUMBA_CACHE_DIR" in check.advice) == ("missing", True)


def test_a_command_without_a_place_for_compiled_code(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"")
    done = subprocess.run(
        [sys.executable, "-m", "tsr_engine", "detect", tmp_path, "--jsonl", tmp_path / "o"], text=True, check=False,
        capture_output=True, timeout=100, env=os.environ | {"NUMBA_CACHE_LOCATOR_CLASSES": "IPythonCacheLocator"},
    )  # fmt: skip
    assert (done.returncode, done.stderr.count("\n")) == (6, 1), done.stderr
    assert "Set NUMBA_CACHE_DIR to a folder that can." in done.stderr


def test_extras_are_reported_as_a_whole(models: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = [
        "numpy>=1.0",
        'no-such-package>=1 ; extra == "scene3d"',
        "typer>=0.1; extra == 'review'",
        'pytest>=999; extra == "dev"',
        'tsr[review]; extra == "all"',
    ]
    monkeypatch.setattr(diagnosis.importlib.metadata, "requires", lambda _: lines)
    checks = by_name(diagnose(models))
    assert checks["extra scene3d"].status == "warning"
    assert checks["extra scene3d"].found == "without no-such-package"
    assert checks["extra scene3d"].advice == "pip install 'tsr[scene3d]'"
    assert checks["extra review"].status == checks["typer"].status == checks["numpy"].status == "ok"
    assert not {"pytest", "tsr[review]", "extra dev"} & checks.keys()


def test_missing_labels_of_a_classifier_are_listed(models: Path) -> None:
    save_component(Component("classifier", {"w": np.arange(4.0)}, {"labels": ["stop", "bus-stop"]}), models)
    found = by_name(diagnose(models))["labels of the classifier"].found
    assert found.startswith("2; of gtsrb-43 it lacks 42: speed-limit-20,")
    assert "labels of the classifier" not in by_name(diagnose())
