"""The Rerun web viewer, copied once from the installed SDK's binary to the data folder.

The binary serves its viewer on a loopback port for as long as the copy takes. Nothing is loaded from the network, and
the version is always that of the SDK that writes the recordings.
"""

from __future__ import annotations

import gzip
import hashlib
import importlib.metadata
import importlib.util
import json
import os
import re
import secrets
import shutil
import signal
import subprocess
import tempfile
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from app.errors import Busy

FILES: Final = {"re_viewer.js": "text/javascript; charset=utf-8", "re_viewer_bg.wasm": "application/wasm"}
"""Files that the page needs, and their media types."""
_MANIFEST: Final = "manifest.json"
_ADDRESS: Final = re.compile(rb"Hosting a web-viewer at (http://127\.0\.0\.1:[0-9]{1,5})")
_START_TIMEOUT_S: Final = 30.0
_FETCH_TIMEOUT_S: Final = 60.0
_MAX_BYTES: Final = 200 * 2**20


def sdk_version() -> str:
    """Version of the installed SDK; empty: it is not installed."""
    try:
        return importlib.metadata.version("rerun-sdk")
    except importlib.metadata.PackageNotFoundError:
        return ""


def viewer_binary() -> Path | None:
    """Find the viewer's binary in the wheel without importing the SDK."""
    spec = importlib.util.find_spec("rerun_cli")
    if spec is None or not spec.submodule_search_locations:
        return None
    path = Path(next(iter(spec.submodule_search_locations))) / "rerun"
    return path if path.is_file() and os.access(path, os.X_OK) else None


@dataclass(frozen=True, slots=True)
class ViewerFile:
    """One file of the viewer.

    Attributes:
        path: the gzipped file.
        media_type: media type of its content.
        size: size of its content, bytes.
        digest: SHA-256 of its content.
    """

    path: Path
    media_type: str
    size: int
    digest: str


class ViewerFiles:
    """The viewer's files, copied on first use. Thread-safe."""

    def __init__(self, home: Path, version: str | None = None, binary: Path | None = None) -> None:
        self.version = sdk_version() if version is None else version
        self.folder = home / "cache" / f"rerun-viewer-{self.version}"
        self._binary = binary
        self._lock = threading.Lock()
        self._known: dict[str, ViewerFile] | None = None

    def file(self, name: str) -> ViewerFile | None:
        """Return one file; None: no such file.

        Raises:
            Busy: the viewer is not available; the sentence says why.
        """
        return self.ensure().get(name)

    def ensure(self) -> dict[str, ViewerFile]:
        """Return all files by name; the first call copies them, which takes some seconds.

        Raises:
            Busy: the viewer is not available; the sentence says why.
        """
        with self._lock:
            files = self._files()
            if files is None:
                self._fetch()
                files = self._files()
            if files is None:
                raise _unavailable(f"its files in {self.folder} cannot be read")
            return files

    def _files(self) -> dict[str, ViewerFile] | None:
        if self._known is not None and all(file.path.is_file() for file in self._known.values()):
            return self._known
        self._known = None
        try:
            manifest = json.loads((self.folder / _MANIFEST).read_text(encoding="utf-8"))
            files = {}
            for name, media_type in FILES.items():
                entry = manifest[name]
                file = ViewerFile(self.folder / f"{name}.gz", media_type, int(entry["size"]), str(entry["sha256"]))
                if file.path.stat().st_size != entry["stored"]:
                    return None
                files[name] = file
        except (OSError, ValueError, KeyError, TypeError):
            return None
        self._known = files
        return files

    def _fetch(self) -> None:
        binary = self._binary or viewer_binary()
        if not self.version or binary is None:
            raise _unavailable("the package rerun-sdk is not installed with its viewer; install it again")
        part = self.folder.with_name(f".{self.folder.name}.{secrets.token_hex(4)}")
        try:
            part.mkdir(parents=True)
            manifest = {}
            with _serving(binary) as address:
                for name in FILES:
                    manifest[name] = _store(f"{address}/{name}", part / f"{name}.gz")
            (part / _MANIFEST).write_text(json.dumps(manifest, indent=1), encoding="utf-8")
            shutil.rmtree(self.folder, ignore_errors=True)
            with suppress(OSError):  # another process has just written the same files
                part.rename(self.folder)
        except (OSError, urllib.error.URLError, subprocess.SubprocessError) as error:
            raise _unavailable(str(error) or type(error).__name__) from None
        finally:
            shutil.rmtree(part, ignore_errors=True)


def _unavailable(why: str) -> Busy:
    return Busy(
        f"The Rerun viewer cannot be shown here: {why}. Download the recording and open it with 'rerun FILE.rrd'.",
        code="no_viewer",
    )


@contextmanager
def _serving(binary: Path) -> Iterator[str]:
    """Run the binary's web server on a free loopback port until the block ends; yields its address."""
    with tempfile.TemporaryDirectory(prefix="tsr-rerun-") as scratch:
        settings = Path(scratch) / "config" / "rerun"
        settings.mkdir(parents=True)
        (settings / "analytics.json").write_text('{"analytics_enabled": false, "analytics_id": "", "metadata": {}}')
        environment = {
            "HOME": scratch,
            "XDG_CONFIG_HOME": str(settings.parent),
            "XDG_DATA_HOME": str(Path(scratch) / "data"),
            "XDG_CACHE_HOME": str(Path(scratch) / "cache"),
            "PATH": os.environ.get("PATH", ""),
            "RUST_LOG": "info",
            "NO_COLOR": "1",
        }
        command = [str(binary), "--serve-web", "--bind", "127.0.0.1", "--web-viewer-port", "0", "--port", "0"]
        log = Path(scratch) / "log"
        with log.open("wb") as output:
            process = subprocess.Popen(  # noqa: S603 - our own binary, no shell
                command,
                stdout=output,
                stderr=subprocess.STDOUT,
                stdin=subprocess.DEVNULL,
                env=environment,
                cwd=scratch,
                start_new_session=True,
            )
        try:
            yield _address(process, log)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait(10)


def _address(process: subprocess.Popen[bytes], log: Path) -> str:
    until = time.monotonic() + _START_TIMEOUT_S
    while time.monotonic() < until:
        output = log.read_bytes()
        found = _ADDRESS.search(output)
        if found is not None:
            return found.group(1).decode()
        if process.poll() is not None:
            raise subprocess.SubprocessError(f"its program ended at once with code {process.returncode}")
        time.sleep(0.05)
    raise subprocess.SubprocessError(f"its program did not start within {_START_TIMEOUT_S:.0f} s")


def _store(address: str, path: Path) -> dict[str, int | str]:
    """Copy one file, gzipped; return its size and digest, and its stored size."""
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    digest, size, until = hashlib.sha256(), 0, time.monotonic() + _FETCH_TIMEOUT_S
    with (
        opener.open(address, timeout=_START_TIMEOUT_S) as answer,
        gzip.GzipFile(path, "wb", compresslevel=6, mtime=0) as out,
    ):
        while chunk := answer.read(1 << 20):
            size += len(chunk)
            if size > _MAX_BYTES or time.monotonic() > until:
                raise OSError(f"{address.rpartition('/')[2]} is too large or arrives too slowly")
            digest.update(chunk)
            out.write(chunk)
    if size == 0:
        raise OSError(f"{address.rpartition('/')[2]} is empty")
    return {"size": size, "sha256": digest.hexdigest(), "stored": path.stat().st_size}
