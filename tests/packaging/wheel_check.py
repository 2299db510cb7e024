"""Try a wheel as a user installs it: ``python -m tests.packaging.wheel_check DIST``.

The wheel in the folder DIST is installed into an empty environment. There `tsr track` must work on the sample drive,
and `tsr review` must say what to install. With the extra `all`, `tsr review` must serve its page from the wheel's own
files. pip needs a package index.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import time
import urllib.request
from http.cookiejar import CookieJar
from pathlib import Path
from tempfile import TemporaryDirectory

from tsr_engine.extras import EXTRAS

BROUGHT = {"matplotlib"}
"""Packages of extras that filterpy brings along."""
MAX_START_S = 240
"""How long the server may take to start, s."""
SAMPLE = "from sample_videos import SHIPPED; print(SHIPPED[0].video)"


class Environment:
    """A new environment with the wheel in it; commands run outside of the repository."""

    def __init__(self, folder: Path, wheel: Path, extra: str = "") -> None:
        self._folder = folder
        self._bin = folder / "venv" / "bin"
        subprocess.run([sys.executable, "-m", "venv", folder / "venv"], check=True)
        self.run("python", "-m", "pip", "install", "--quiet", f"{wheel}{extra}")

    def run(self, program: str, *arguments: str, code: int = 0) -> str:
        """Run a command of the environment; returns its stdout and stderr, and checks the exit code."""
        done = subprocess.run(
            [self._bin / program, *arguments], cwd=self._folder, capture_output=True, text=True, timeout=1800
        )
        error_output = done.stdout + done.stderr
        if done.returncode != code:
            raise SystemExit(
                f"{program} {' '.join(arguments)} ended with {done.returncode}, not {code}:\n{error_output}"
            )
        return error_output

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        with (self._folder / "log").open("w") as log:
            return subprocess.Popen(
                [self._bin / "tsr", *arguments], cwd=self._folder, stdout=log, stderr=log, text=True
            )

    @property
    def log(self) -> str:
        """Output of the running command."""
        return (self._folder / "log").read_text()


def check_base(folder: Path, wheel: Path) -> None:
    """`tsr track` works without extras; commands that need an extra say so."""
    base = Environment(folder, wheel)
    for name in sorted({name for names in EXTRAS.values() for name in names} - BROUGHT):
        found = base.run(
            "python", "-c", f"import importlib.util; print(importlib.util.find_spec({name!r}) is not None)"
        )
        _expect(found.strip() == "False", f"the base installation brings {name}")
    base.run("tsr", "--help")
    doctor = base.run("tsr", "doctor")
    _expect("pip install 'tsr[review]'" in doctor, f"tsr doctor does not name the extras:\n{doctor}")
    sample = base.run("python", "-c", SAMPLE).strip()
    _expect(str(folder) in sample, f"the sample drive is not that of the wheel: {sample}")
    base.run("tsr", "track", sample, "--csv", "rows.csv")
    _expect(len((folder / "rows.csv").read_text().splitlines()) > 100, "tsr track has found too little")
    refused = base.run("tsr", "review", code=2)
    _expect("pip install 'tsr[review]'" in refused, f"tsr review without its extra says: {refused}")


def check_all(folder: Path, wheel: Path) -> None:
    """`tsr review` serves the page from the files of the wheel."""
    whole = Environment(folder, wheel, "[all]")
    doctor = whole.run("tsr", "doctor")
    _expect("missing" not in doctor, doctor)
    server = whole.start("review", "--home", str(folder / "home"), "--port", "0", "--no-browser", "--no-sample")
    try:
        end, found = time.monotonic() + MAX_START_S, None
        while found is None:
            _expect(server.poll() is None and time.monotonic() < end, f"the server does not start:\n{whole.log}")
            time.sleep(0.2)
            found = re.search(r"(http://[^/\s]+)/login/\S+", whole.log)
        browser = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(CookieJar()))
        page = browser.open(found.group(0), timeout=60).read().decode()
        scripts = re.findall(r'src="(/static/[^"]+\.js)"', page)
        _expect(bool(scripts), f"the page names no script:\n{page[:500]}")
        for script in scripts:
            served = browser.open(found.group(1) + script, timeout=60).read()
            shipped = next((folder / "venv").rglob("site-packages/app" + re.sub(r"/v-[0-9a-f]{16}/", "/", script)))
            _expect(served == shipped.read_bytes(), f"{script} is not the file of the wheel")
    finally:
        server.terminate()
        server.wait(timeout=30)


def _expect(holds: bool, sentence: str) -> None:
    if not holds:
        raise SystemExit(sentence)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.packaging.wheel_check", description=__doc__)
    parser.add_argument("dist", type=Path, help="folder with the wheel")
    wheels = sorted(parser.parse_args().dist.resolve().glob("tsr-*.whl"), key=lambda wheel: wheel.stat().st_mtime)
    if not wheels:
        raise SystemExit("There is no wheel. Build one: make wheel.")
    for check in (check_base, check_all):
        with TemporaryDirectory() as folder:
            check(Path(folder), wheels[-1])
        print(f"{wheels[-1].name}: {check.__name__} holds", flush=True)


if __name__ == "__main__":
    main()
