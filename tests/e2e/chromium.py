"""Where the browser of the tests is; as a script it fetches one where there is none, and prints its path.

``CHROMIUM`` names one; set but empty it means none. Otherwise the first of ``NAMES`` on the PATH is taken. One without
windows comes first: a page costs less than half the CPU time there, as a whole browser draws its bars as pages too.
Where there is none, root gets Debian's package. Others, and who does not get that one, get the build that the npm
package ``@sparticuz/chromium`` carries, in a folder of the environment.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

__all__ = ["CHROMIUM", "ENVIRONMENT", "HOW"]

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
OWN = Path(sys.prefix) / "chromium"
"""The folder of a fetched one."""
HOW = (
    "Install it (on Debian: apt install chromium), or name another one: make test CHROMIUM=/path/to/chrome. "
    "Then run make test again."
)
ENVIRONMENT: dict[str, str | float | bool] = {**os.environ, "LC_ALL": "en_US.UTF-8"}
"""What its process is given: of a locale POSIX or C it may make a language that pages refuse."""
PACKAGE = "@sparticuz/chromium"
UNPACK = f'const {{ default: chromium }} = await import("{PACKAGE}"); console.log(await chromium.executablePath());'
START = """#!/bin/sh
here=$(dirname "$0")
export LC_ALL=en_US.UTF-8 LD_LIBRARY_PATH="$here/al2023/lib:$LD_LIBRARY_PATH"
exec "$here/chromium" "$@"
"""
"""The package brings the libraries that a server may lack; of a locale POSIX it makes a language that pages refuse."""


def find() -> Path | None:
    """The browser to use; None: there is none, or ``CHROMIUM`` is set to nothing."""
    named = os.environ.get("CHROMIUM")
    if named is not None:
        return Path(named) if named else None
    for name in (*NAMES, str(OWN / "start")):
        found = shutil.which(name)
        if found:
            return Path(found)
    return None


def fetch() -> None:
    """Install one, by the package manager of the system, else into the environment.

    Raises:
        OSError: a program that this needs is missing, or the browser does not start.
        subprocess.SubprocessError: a program failed.
    """
    if shutil.which("apt-get") and os.geteuid() == 0:
        try:
            _install()
        except subprocess.SubprocessError as error:
            _say(f"Debian's chromium could not be installed ({error}).")
        else:
            return
    _say(f"Fetching a Chromium into {OWN}, once ...")
    OWN.mkdir(parents=True, exist_ok=True)
    tools = Path(sys.executable).parent
    _run([str(tools / "npm"), "install", "--prefix", str(OWN), "--no-package-lock", "--no-audit", "--silent", PACKAGE])
    # It unpacks into the folder for temporary files, and the libraries only where it takes itself to run at Amazon's.
    place = {**os.environ, "TMPDIR": str(OWN), "AWS_EXECUTION_ENV": "AWS_Lambda_nodejs22.x"}
    _run([str(tools / "node"), "--input-type=module", "--eval", UNPACK], place, OWN)
    start = OWN / "start"
    start.write_text(START)
    try:
        start.chmod(0o755)
        _run([str(start), "--version"])
    except (OSError, subprocess.SubprocessError):
        start.unlink()
        raise


def _install() -> None:
    _say("Installing Debian's chromium, once ...")
    quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    for words in (["update", "-qq"], ["install", "-y", "-qq", "chromium"]):
        _run(["apt-get", *words], quiet)


def _run(command: list[str], environment: dict[str, str] | None = None, folder: Path | None = None) -> None:
    """Run a program; what it says goes to stderr."""
    subprocess.run(command, env=environment, cwd=folder, check=True, stdout=sys.stderr, timeout=900)


def _say(sentence: str) -> None:
    print(sentence, file=sys.stderr, flush=True)


CHROMIUM = find() or Path("chromium")
"""The browser; a file that is not there where none was found."""


def main() -> None:
    """Print the path of the browser, of a fetched one if need be; nothing where there is none."""
    found = find()
    if found is None and "CHROMIUM" not in os.environ:
        try:
            fetch()
        except (OSError, subprocess.SubprocessError) as error:
            _say(f"No Chromium could be fetched ({error}). The tests of the page in a browser are left out.")
        found = find()
    if found is not None:
        print(found)


if __name__ == "__main__":
    main()
