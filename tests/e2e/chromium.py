"""Finds the browser of the tests; as a script it downloads one if there is none, and prints its path.

``CHROMIUM`` names a browser; set but empty, it means none. Otherwise the first of ``NAMES`` on the PATH is used.
Headless ones come first: a page takes less than half the CPU time there, because a full browser draws its bars as pages
too. Without a browser, root installs Debian's package. Other users, and root if that fails, get the build in the npm
package ``@sparticuz/chromium``, in a folder of the environment.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

__all__ = ["CHROMIUM", "ENVIRONMENT", "INSTALL_HINT"]

HEADLESS_SHELL = "chromium-headless-shell"
"""One without windows, and Debian's package of it."""
NAMES = (HEADLESS_SHELL, "chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
DOWNLOAD_FOLDER = Path(sys.prefix) / "chromium"
"""The folder of a fetched one."""
HEADLESS_TRIED = "tried"
"""A file in that folder: a headless browser could not be installed beside a full one."""
MAX_STEP_S = 900.0
"""Seconds that a step of an installation may take where there is no browser."""
MAX_HEADLESS_STEP_S = 120.0
"""The same where there is one already."""
INSTALL_HINT = (
    f"Install it (on Debian: apt install {HEADLESS_SHELL}), or name another one: make test CHROMIUM=/path/to/chrome. "
    "Then run make test again."
)
ENVIRONMENT: dict[str, str | float | bool] = {**os.environ, "LC_ALL": "en_US.UTF-8"}
"""Environment of its process: in a POSIX or C locale it may report a language that pages refuse."""
PACKAGE = "@sparticuz/chromium"
UNPACK_SCRIPT = (
    f'const {{ default: chromium }} = await import("{PACKAGE}"); console.log(await chromium.executablePath());'
)
START_SCRIPT = """#!/bin/sh
here=$(dirname "$0")
export LC_ALL=en_US.UTF-8 LD_LIBRARY_PATH="$here/al2023/lib:$LD_LIBRARY_PATH"
exec "$here/chromium" "$@"
"""
"""The package brings the libraries that a server may lack; of a locale POSIX it makes a language that pages refuse."""


def find() -> Path | None:
    """The browser to use; None: there is none, or ``CHROMIUM`` is empty."""
    named = os.environ.get("CHROMIUM")
    if named is not None:
        return Path(named) if named else None
    for name in (*NAMES, str(DOWNLOAD_FOLDER / "start")):
        found = shutil.which(name)
        if found:
            return Path(found)
    return None


def fetch() -> None:
    """Install a browser with the system's package manager, else into the environment.

    Raises:
        OSError: a required program is missing, or the browser does not start.
        subprocess.SubprocessError: a program failed.
    """
    if _has_debian_packages():
        for package in (HEADLESS_SHELL, "chromium"):
            try:
                _install(package)
            except subprocess.SubprocessError as error:
                _print_error(f"Debian's {package} could not be installed ({error}).")
            else:
                return
    _print_error(f"Fetching a Chromium into {DOWNLOAD_FOLDER}, once ...")
    DOWNLOAD_FOLDER.mkdir(parents=True, exist_ok=True)
    tools = Path(sys.executable).parent
    _run(
        [
            str(tools / "npm"),
            "install",
            "--prefix",
            str(DOWNLOAD_FOLDER),
            "--no-package-lock",
            "--no-audit",
            "--silent",
            PACKAGE,
        ]
    )
    # It unpacks into the folder for temporary files, and the libraries only if it believes to run on AWS.
    place = {**os.environ, "TMPDIR": str(DOWNLOAD_FOLDER), "AWS_EXECUTION_ENV": "AWS_Lambda_nodejs22.x"}
    _run([str(tools / "node"), "--input-type=module", "--eval", UNPACK_SCRIPT], place, DOWNLOAD_FOLDER)
    start = DOWNLOAD_FOLDER / "start"
    start.write_text(START_SCRIPT)
    try:
        start.chmod(0o755)
        _run([str(start), "--version"])
    except (OSError, subprocess.SubprocessError):
        start.unlink()
        raise


def _has_debian_packages() -> bool:
    """Whether packages of Debian can be installed."""
    return shutil.which("apt-get") is not None and os.geteuid() == 0


def _install_headless() -> None:
    """Install Debian's headless package beside a full browser, if possible; tried once."""
    if not _has_debian_packages() or (DOWNLOAD_FOLDER / HEADLESS_TRIED).exists():
        return
    try:
        DOWNLOAD_FOLDER.mkdir(parents=True, exist_ok=True)
        (DOWNLOAD_FOLDER / HEADLESS_TRIED).touch()
        _install(HEADLESS_SHELL, MAX_HEADLESS_STEP_S)
    except (OSError, subprocess.SubprocessError) as error:
        _print_error(
            f"Debian's {HEADLESS_SHELL} could not be installed ({error}). The tests take longer with this browser."
        )


def _install(package: str, seconds: float = MAX_STEP_S) -> None:
    _print_error(f"Installing Debian's {package}, once ...")
    quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    for words in (["update", "-qq"], ["install", "-y", "-qq", package]):
        _run(["apt-get", *words], quiet, seconds=seconds)


def _run(
    command: list[str],
    environment: dict[str, str] | None = None,
    folder: Path | None = None,
    seconds: float = MAX_STEP_S,
) -> None:
    """Run a program; its output goes to stderr."""
    subprocess.run(command, env=environment, cwd=folder, check=True, stdout=sys.stderr, timeout=seconds)


def _print_error(sentence: str) -> None:
    print(sentence, file=sys.stderr, flush=True)


CHROMIUM = find() or Path(NAMES[0])
"""The browser; a file that is not there where none was found."""


def main() -> None:
    """Print the path of the browser, downloaded if necessary; nothing if there is none."""
    found = find()
    if "CHROMIUM" not in os.environ:
        if found is None:
            try:
                fetch()
            except (OSError, subprocess.SubprocessError) as error:
                _print_error(
                    f"No Chromium could be fetched ({error}). The tests of the page in a browser are left out."
                )
        elif found.name in NAMES[1:]:
            _install_headless()
        found = find()
    if found is not None:
        print(found)


if __name__ == "__main__":
    main()
