"""The application as a whole: page files, ranges, compression, and errors outside of routes."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest
from fastapi import APIRouter
from fastapi.responses import FileResponse, PlainTextResponse, StreamingResponse

import app.pages
from app.page_files import page_version, static_folder
from tests.app.toy_server import Server
from tests.waiting import time_limit


@pytest.mark.parametrize("path", ["/", "/index.html", "/favicon.ico", "/static/js/main.js"])
def test_the_page_is_revalidated(server: Server, path: str) -> None:
    first = server.stranger().get(path)
    assert first.status_code == 200
    assert first.headers["cache-control"] == "no-cache"
    again = server.stranger().get(path, headers={"If-None-Match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    head = server.stranger().head(path)
    assert (head.status_code, head.content) == (200, b"")


def test_files_of_the_page_are_cached_until_one_changes(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    def scripts() -> list[str]:
        return re.findall(r'src="(/static/v-[0-9a-f]{16}/js/[^"]+)"', server.stranger().get("/").text)

    (named, *_), before = scripts(), app.pages.page_version
    kept = server.stranger().get(named)
    assert (kept.status_code, "immutable" in kept.headers["cache-control"]) == (200, True)
    for other in ("/static/v-0123456789abcdef/" + named.split("/", 3)[3], "/static/" + named.split("/", 3)[3]):
        answer = server.stranger().get(other)
        assert (answer.content, answer.headers["cache-control"]) == (kept.content, "no-cache")
    monkeypatch.setattr(app.pages, "page_version", lambda folder: before(folder)[::-1])  # simulate a changed file
    assert scripts()[0] != named
    assert server.stranger().get(named).headers["cache-control"] == "no-cache"


def test_a_file_is_the_same_when_it_comes_from_memory(server: Server) -> None:
    page = server.stranger().get("/").text
    named = re.findall(r'"(/static/v-[0-9a-f]{16}/js/main.js)"', page)[0]
    first, again = (server.stranger().get(named, headers={"Accept-Encoding": "gzip"}) for _ in range(2))
    assert first.content == again.content == (static_folder() / "js" / "main.js").read_bytes()
    for header in ("cache-control", "content-encoding", "content-type", "etag", "vary"):
        assert first.headers[header] == again.headers[header]
    plain = server.stranger().get(named, headers={"Accept-Encoding": ""})
    assert (plain.content, "content-encoding" in plain.headers) == (first.content, False)
    assert server.stranger().get(named, headers={"If-None-Match": plain.headers["etag"]}).status_code == 304
    part = server.stranger().get(named, headers={"Range": "bytes=0-3"})
    assert (part.status_code, part.content) == (206, first.content[:4])
    assert server.stranger().head(named).content == b""
    assert server.stranger().post(named).status_code == 405


def test_a_file_of_the_page_is_read_once(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    version = re.findall(r"/static/v-[0-9a-f]{16}/", server.stranger().get("/").text)[0]
    content = (static_folder() / "js" / "sign_in.js").read_bytes()
    read: list[str] = []

    def noted(path: Path) -> bytes:
        read.append(path.name)
        with path.open("rb") as file:
            return file.read()

    monkeypatch.setattr(Path, "read_bytes", noted)
    monkeypatch.setattr(FileResponse, "__call__", None)  # it would read the file once more
    assert [server.stranger().get(f"{version}js/sign_in.js").content for _ in range(3)] == [content] * 3
    assert read == ["sign_in.js"]


def test_the_version_changes_with_every_file(tmp_path: Path) -> None:
    seen = [page_version(tmp_path)]
    (tmp_path / "a.js").write_text("1")
    seen.append(page_version(tmp_path))
    (tmp_path / "a.js").write_text("22")
    seen.append(page_version(tmp_path))
    (tmp_path / "a.js").rename(tmp_path / "b.js")
    seen.append(page_version(tmp_path))
    (tmp_path / "views").mkdir()
    (tmp_path / "views" / "b.js").write_text("22")
    seen.append(page_version(tmp_path))
    there = (tmp_path / "views" / "b.js").stat()
    (tmp_path / "views" / "b.js").write_text("33")
    os.utime(tmp_path / "views" / "b.js", ns=(there.st_atime_ns, there.st_mtime_ns + 1))
    seen.append(page_version(tmp_path))
    assert len(set(seen)) == 6
    (tmp_path / ".#b.js").symlink_to("nowhere")
    assert page_version(tmp_path) == seen[-1]


def test_another_installation_of_the_same_files_has_the_same_version(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.js").write_text("1")
        os.utime(tmp_path / name / "a.js", (len(name), 1 if name == "one" else 2))
    assert page_version(tmp_path / "one") == page_version(tmp_path / "two")


def test_the_session_names_the_files_of_the_page(server: Server) -> None:
    files = re.findall(r'"/static/v-([0-9a-f]{16})/js/main.js"', server.stranger().get("/").text)
    assert [server.client.get("/api/session").json()["page"]] == files


def test_every_file_of_the_page_has_a_valid_type(server: Server) -> None:
    folder = static_folder()
    types = {".js": "text/javascript", ".css": "text/css", ".html": "text/html", ".svg": "image/svg+xml"}
    for file in folder.rglob("*"):
        if file.is_file() and file.suffix in types:
            answer = server.stranger().get(f"/static/{file.relative_to(folder)}")
            assert answer.content == file.read_bytes(), file
            assert answer.headers["content-type"].startswith(types[file.suffix]), file
    page = (folder / "index.html").read_text(encoding="utf-8")
    for named in re.findall(r'(?:src|href)="(/[^"]+)"', page):
        assert server.stranger().get(named).status_code == 200, named


def test_text_is_compressed_and_pictures_are_not(server: Server) -> None:
    headers = {"Accept-Encoding": "gzip"}
    assert server.client.get("/static/js/main.js", headers=headers).headers["content-encoding"] == "gzip"
    assert server.client.get("/api/openapi.json", headers=headers).headers["content-encoding"] == "gzip"
    assert "content-encoding" not in server.client.get("/api/labels/1.png", headers=headers).headers
    assert "content-encoding" not in server.client.get("/static/js/main.js", headers={"Accept-Encoding": ""}).headers


@pytest.mark.parametrize(
    "ranges", [",".join(f"{n}-{n}" for n in range(5000)), ",".join(["0-"] * 20_000), "5-2", "9999999-", "-", "x"]
)
def test_ranges_are_served_and_refused_with_an_error_body(server: Server, ranges: str) -> None:
    took = []
    for _ in range(3):
        began = time.perf_counter()
        answer = server.client.get("/static/js/main.js", headers={"Range": f"bytes={ranges}"})
        took.append(time.perf_counter() - began)
    assert min(took) < time_limit(0.1)
    assert len(answer.content) < 3 * (static_folder() / "js" / "main.js").stat().st_size
    if answer.status_code >= 400:
        assert set(answer.json()["error"]) == {"code", "message", "field", "details"}
        assert answer.json()["error"]["message"].endswith(".")


def test_every_error_has_the_same_body(tmp_path: Path) -> None:
    server = Server(tmp_path / "home")
    odd = APIRouter()

    @odd.get("/odd/plain")
    def plain() -> PlainTextResponse:
        return PlainTextResponse("Too hot", status_code=429, headers={"Retry-After": "3"})

    @odd.get("/odd/broken")
    def broken() -> StreamingResponse:
        def parts() -> object:
            yield b"half"
            raise RuntimeError("a secret detail")

        return StreamingResponse(parts())

    server.app.include_router(odd)
    with server.client as client:
        answer = client.get("/odd/plain")
        assert answer.status_code == 429
        assert answer.json()["error"]["message"] == "Too hot."
        assert answer.headers["retry-after"] == "3"
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert b"secret" not in client.get("/odd/broken").content


def test_the_document_needs_credentials_and_no_docs_page_is_served(server: Server) -> None:
    assert server.stranger().get("/api/openapi.json").status_code == 401
    for path in ("/docs", "/redoc", "/openapi.json"):
        assert server.client.get(path).status_code == 404


def test_a_server_starts_without_modules_of_the_engine() -> None:
    """The compiler alone takes 54 MB and a second; an idle server must be small and start fast."""
    heavy = "{'numba', 'sklearn', 'scipy', 'rerun', 'viser', 'onnxruntime', 'matplotlib', 'sample_videos.drive'}"
    code = f"import sys, app.main; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=300)
    assert done.stdout.strip() == "[]"
