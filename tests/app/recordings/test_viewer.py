"""The viewer's files: extracted from the SDK once, and served so that nothing leaves this server."""

from __future__ import annotations

import gzip
import hashlib
import json
import os
import stat
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from app.errors import Busy
from app.recordings.viewer import FILES, ViewerFiles, sdk_version
from tests.app.toy_server import Server

IMITATION = '''#!{python}
"""Serves two files as the SDK's binary does, and notes how it was started."""
import http.server, json, os, pathlib, sys
pathlib.Path({log!r}).open("a").write(json.dumps([sys.argv[1:], dict(os.environ)]) + "\\n")
class Files(http.server.BaseHTTPRequestHandler):
    def do_GET(self):
        self.send_response(200); self.end_headers(); self.wfile.write(("content of " + self.path).encode() * 999)
    def log_message(self, *_): pass
server = http.server.HTTPServer(("127.0.0.1", 0), Files)
print("INFO Hosting a web-viewer at http://127.0.0.1:%d - connect" % server.server_address[1], flush=True)
server.serve_forever()
'''


def program(path: Path, text: str) -> Path:
    path.write_text(text)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


@pytest.fixture
def imitation(tmp_path: Path) -> Path:
    return program(tmp_path / "rerun", IMITATION.format(python=sys.executable, log=str(tmp_path / "starts")))


def recorded_starts(folder: Path) -> list[Any]:
    return [json.loads(line) for line in (folder / "starts").read_text().splitlines()]


def test_files_are_extracted_once_and_kept_gzipped(imitation: Path, tmp_path: Path) -> None:
    files = ViewerFiles(tmp_path / "home", "9.9.9", imitation)
    assert not files.folder.exists()
    threads = [threading.Thread(target=files.ensure) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    for name, file in ViewerFiles(tmp_path / "home", "9.9.9", imitation).ensure().items():
        content = gzip.decompress(file.path.read_bytes())
        assert content == f"content of /{name}".encode() * 999
        assert (file.size, file.digest) == (len(content), hashlib.sha256(content).hexdigest())
    ((arguments, environment),) = recorded_starts(tmp_path)
    assert arguments[1:3] == ["--bind", "127.0.0.1"], "nobody else can reach it"
    assert environment["HOME"] != os.environ.get("HOME"), "nothing is written into the person's own settings"
    assert sorted(p.name for p in (tmp_path / "home" / "cache").iterdir()) == ["rerun-viewer-9.9.9"]


def test_a_damaged_copy_is_replaced(imitation: Path, tmp_path: Path) -> None:
    folder = ViewerFiles(tmp_path, "9.9.9", imitation).ensure()["re_viewer.js"].path.parent
    (folder / "re_viewer.js.gz").write_bytes(b"half")
    assert ViewerFiles(tmp_path, "9.9.9", imitation).ensure()["re_viewer.js"].path.stat().st_size > 4
    (folder / "manifest.json").write_text("[]")
    assert ViewerFiles(tmp_path, "9.9.9", imitation).ensure()
    assert len(recorded_starts(tmp_path)) == 3


@pytest.mark.parametrize("text", ["#!/bin/sh\nexit 3\n", "not a program"])
def test_a_program_that_does_not_start_is_one_sentence(text: str, tmp_path: Path) -> None:
    files = ViewerFiles(tmp_path / "home", "9.9.9", program(tmp_path / "rerun", text))
    with pytest.raises(
        Busy, match=r"cannot be shown here: .* Download the recording and open it with 'rerun FILE.rrd'"
    ):
        files.ensure()
    assert not list((tmp_path / "home" / "cache").iterdir())


def test_a_folder_that_cannot_be_written_is_one_sentence(imitation: Path, tmp_path: Path) -> None:
    (tmp_path / "cache").touch()
    with pytest.raises(Busy, match="cannot be shown here: .*cache"):
        ViewerFiles(tmp_path, "9.9.9", imitation).ensure()


def test_the_installed_sdk_has_the_required_viewer(tmp_path_factory: pytest.TempPathFactory) -> None:
    assert sdk_version().startswith("0.41."), "the page speaks the protocol of this version: see protocol.js"
    # Browser tests share this copy.
    found = ViewerFiles(tmp_path_factory.getbasetemp() / "rerun-viewer").ensure()
    assert gzip.decompress(found["re_viewer_bg.wasm"].path.read_bytes())[:4] == b"\0asm"
    script = gzip.decompress(found["re_viewer.js"].path.read_bytes()).decode()
    for needed in (
        "let wasm_bindgen",
        "class WebHandle",
        "open_channel(id",
        "send_rrd_to_channel(id, data)",
        "close_channel(id",
        "viewer_control(request_bytes)",
        "has_panicked()",
        "panic_message()",
    ):
        assert needed in script, f"the viewer has changed: {needed} is gone"
    assert found["re_viewer_bg.wasm"].path.stat().st_size < 25e6


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder = tmp_path_factory.mktemp("server")
    text = IMITATION.format(python=sys.executable, log=str(folder / "starts"))
    server = Server(folder / "home")
    files = ViewerFiles(folder / "home", "9.9.9", program(folder / "rerun", text))
    object.__setattr__(server.context, "viewer", files)
    with server.client:
        yield server


def test_files_are_served_gzipped_and_immutable(server: Server) -> None:
    assert server.client.get("/rerun/state").json() == {"ready": True, "version": "9.9.9", "message": ""}
    for name, media_type in FILES.items():
        answer = server.client.get(f"/rerun/9.9.9/{name}")
        assert answer.status_code == 200
        assert answer.content == f"content of /{name}".encode() * 999
        assert answer.headers["content-encoding"] == "gzip"
        assert answer.headers["content-type"] == media_type
        assert "immutable" in answer.headers["cache-control"]
        again = server.client.get(f"/rerun/9.9.9/{name}", headers={"If-None-Match": answer.headers["etag"]})
        assert again.status_code == 304


def test_the_viewers_page_can_reach_nothing_else(server: Server) -> None:
    answer = server.client.get("/rerun/viewer.html")
    assert answer.status_code == 200
    policy = dict(part.strip().split(" ", 1) for part in answer.headers["content-security-policy"].split(";"))
    assert policy["default-src"] == "'none'"
    assert policy["connect-src"] == "'self' data: blob:"
    assert policy["script-src"] == "'self' 'wasm-unsafe-eval'"
    assert policy["frame-ancestors"] == "'self'"
    assert not [value for value in policy.values() if "http" in value or "*" in value]
    assert "http" not in answer.text.replace("http-equiv", "")
    page = server.client.get("/").headers["content-security-policy"]
    assert "frame-src 'self';" in page


@pytest.mark.parametrize(
    "path", ["/rerun/state", "/rerun/viewer.html", "/rerun/9.9.9/re_viewer.js", f"/rerun/recordings/{'0' * 32}.rrd"]
)
def test_files_need_a_credential(path: str, server: Server) -> None:
    assert server.stranger().get(path).status_code == 401
    assert server.client.get(path, headers={"Host": "evil.example"}).status_code == 400


@pytest.mark.parametrize(
    "path",
    [
        "/rerun/9.9.8/re_viewer.js",
        "/rerun/9.9.9/manifest.json",
        "/rerun/9.9.9/..%2Fmanifest.json",
        "/rerun/9.9.9/",
        "/rerun",
        f"/rerun/recordings/{'0' * 32}.rrd",
    ],
)
def test_unknown_files_are_404(path: str, server: Server) -> None:
    answer = server.client.get(path)
    assert answer.status_code == 404
    assert answer.json()["error"]["code"] == "not_found"


def test_a_missing_viewer_is_reported_and_the_server_continues(server: Server, tmp_path: Path) -> None:
    broken = ViewerFiles(tmp_path / "other", "9.9.9", program(tmp_path / "broken", "#!/bin/sh\nexit 1\n"))
    whole = server.context.viewer
    object.__setattr__(server.context, "viewer", broken)
    try:
        reported = server.client.get("/rerun/state").json()
        assert reported["ready"] is False
        assert "its program ended at once with code 1" in reported["message"]
        assert server.client.get("/rerun/9.9.9/re_viewer.js").status_code == 503
    finally:
        object.__setattr__(server.context, "viewer", whole)
