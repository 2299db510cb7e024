"""Sources of the browser for the tests, and the report if there is none."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.e2e import chromium

ROOT = Path(__file__).parents[1]


def program(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return path


@pytest.fixture
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A machine without a browser: an empty folder is its whole PATH."""
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder))
    monkeypatch.delenv("CHROMIUM", raising=False)
    monkeypatch.setattr(chromium, "DOWNLOAD_FOLDER", tmp_path / "own")
    return folder


def test_a_named_browser_comes_first_and_an_empty_name_means_none(empty: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program(empty / "chromium", "")
    monkeypatch.setenv("CHROMIUM", "/elsewhere/chrome")
    assert chromium.find() == Path("/elsewhere/chrome")
    monkeypatch.setenv("CHROMIUM", "")
    assert chromium.find() is None
    monkeypatch.delenv("CHROMIUM")
    assert chromium.find() == empty / "chromium"


def test_other_names_and_a_downloaded_browser_are_found(empty: Path) -> None:
    assert chromium.find() is None
    fetched = program(chromium.DOWNLOAD_FOLDER / "start", "")
    assert chromium.find() == fetched
    program(empty / "google-chrome", "")
    assert chromium.find() == empty / "google-chrome"
    program(empty / chromium.HEADLESS_SHELL, "")
    assert chromium.find() == empty / chromium.HEADLESS_SHELL


def test_root_gets_the_package_of_debian(
    empty: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    made = empty / chromium.HEADLESS_SHELL
    program(
        empty / "apt-get", f'echo "$@" >> {empty}/asked; [ "$1" = update ] || {{ : > {made}; /bin/chmod +x {made}; }}'
    )
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    chromium.main()
    assert capfd.readouterr().out == f"{made}\n"
    assert (empty / "asked").read_text() == "update -qq\ninstall -y -qq chromium-headless-shell\n"
    chromium.main()
    assert (empty / "asked").read_text().count("install") == 1


def test_root_gets_a_headless_browser_if_it_works_at_once(
    empty: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    whole = program(empty / "chromium", "")
    program(empty / "apt-get", f'echo "$@" >> {empty}/asked; exit 100')
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    chromium.main()
    assert not (empty / "asked").exists()
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    for _ in range(2):
        chromium.main()
        assert capfd.readouterr().out.splitlines()[-1] == str(whole)
    assert (empty / "asked").read_text() == "update -qq\n"  # not again
    without = program(empty / chromium.HEADLESS_SHELL, "")
    chromium.main()
    assert capfd.readouterr().out == f"{without}\n"


@pytest.mark.parametrize("root", [False, True])
def test_other_users_get_a_browser_from_npm_that_has_started_once(
    root: bool, empty: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    tools = tmp_path / "tools"
    program(empty / "dirname", 'exec /usr/bin/dirname "$@"')
    program(empty / "apt-get", "exit 1")
    program(tools / "npm", 'echo "$@" > "$3/asked"')
    program(
        tools / "node", r'printf "#!/bin/sh\necho Chromium 1" > "$TMPDIR/chromium"; /bin/chmod +x "$TMPDIR/chromium"'
    )
    monkeypatch.setattr(os, "geteuid", lambda: 0 if root else 1000)
    monkeypatch.setattr(sys, "executable", str(tools / "python"))
    chromium.main()
    assert capfd.readouterr().out == f"{chromium.DOWNLOAD_FOLDER / 'start'}\n"
    assert (chromium.DOWNLOAD_FOLDER / "asked").read_text().endswith("@sparticuz/chromium\n")
    # a browser that does not start does not count
    program(tools / "node", r'printf "#!/bin/sh\nexit 1" > "$TMPDIR/chromium"; /bin/chmod +x "$TMPDIR/chromium"')
    (chromium.DOWNLOAD_FOLDER / "start").unlink()
    chromium.main()
    assert capfd.readouterr().out == ""
    assert not (chromium.DOWNLOAD_FOLDER / "start").exists()


def test_a_failed_download_is_reported_and_tests_continue(
    empty: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    program(empty / "apt-get", "exit 100")
    program(tmp_path / "tools" / "npm", "exit 7")
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    monkeypatch.setattr(sys, "executable", str(tmp_path / "tools" / "python"))
    chromium.main()
    captured = capfd.readouterr()
    assert captured.out == ""
    assert "Debian's chromium could not be installed" in captured.err
    assert f"Debian's {chromium.HEADLESS_SHELL} could not be installed" in captured.err
    assert "No Chromium could be fetched" in captured.err
    assert "are left out" in captured.err


def test_skipped_browser_tests_are_listed_before_the_summary() -> None:
    environment = {**os.environ, "CHROMIUM": "/elsewhere/chrome"}
    environment.pop("TSR_DATA", None)
    command = [sys.executable, "-m", "pytest", "-q", "--numprocesses", "1", "tests/e2e/test_two_pages.py"]
    result = subprocess.run([*command, "tests/geometry"], env=environment, cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout
    *_, hint, closing = result.stdout.strip().splitlines()
    assert hint == f"3 tests did not run: they need a browser, and there is no Chromium. {chromium.INSTALL_HINT}"
    assert " passed, 3 skipped in " in closing
