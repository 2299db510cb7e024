"""The review tool opens video files in one module only."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DOOR = "app/videos/checked_file.py"
BY_NAME = {"video_sha256", "open_container", "VideoCapture"}
"""What would open a file by a name; ``open_video`` and the engine's requests take what the door gives."""
COMMAND_LINE = {"app/cli/review.py", "app/cli/data_folder.py", "app/exchange/dataset.py"}
"""Files that a person names on the command line are that person's to read, through whatever links."""
ASKED = {"is_file", "name", "suffix", "parent"}
"""What may be asked about the name of a video's file without opening it."""
SOURCES = sorted((ROOT / "app").rglob("*.py"))


def offences(text: str) -> list[str]:
    """Operations on names of videos that only the opening module may do."""
    tree = ast.parse(text)
    found = []
    attribute_bases = {
        id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Attribute) and node.attr in ASKED
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom | ast.Import):
            names = {alias.name for alias in node.names}
            found += sorted(names & {*BY_NAME, "av"})
        if isinstance(node, ast.Attribute) and node.attr in BY_NAME:
            found.append(node.attr)
        if not isinstance(node, ast.Call):
            continue
        called = node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")
        of_row = any(
            isinstance(part, ast.Attribute) and part.attr == "path" and _is_row(part.value)
            for argument in node.args
            for part in ast.walk(argument)
        )
        if called == "Path" and of_row and id(node) not in attribute_bases:
            found.append(ast.unparse(node))
        if called in ("open_video", "check_file", "by_name") and any(
            isinstance(part, ast.Name) and part.id in ("Path", "path", "str") for a in node.args for part in ast.walk(a)
        ):
            found.append(ast.unparse(node))
    return found


def _is_row(node: ast.expr) -> bool:
    """Whether an expression is a row of a video, by the variable names in use."""
    return isinstance(node, ast.Name) and node.id in ("video", "row", "known", "found", "clip")


ALLOWED = {
    # an upload replaces or removes a file: names, not bytes
    "app/videos/service.py": {"Path(known.path)", "Path(video.path)"},
    # found again by its content, or removed from a message
    "app/videos/error_text.py": {"Path(video.path)"},
}


def test_no_module_opens_a_video_by_its_name() -> None:
    found = {}
    for path in SOURCES:
        name = path.relative_to(ROOT).as_posix()
        if name != DOOR and name not in COMMAND_LINE:
            found[name] = set(offences(path.read_text(encoding="utf-8"))) - ALLOWED.get(name, set())
    assert {name: wrong for name, wrong in found.items() if wrong} == {}, "use app.videos.checked_file"


DECODING = {"open_video", "cv2.imdecode", "cv2.imread", "Image.open"}
DECODERS = {
    "app/videos/decoding.py": "in a sandbox",
    "app/videos/importing.py": "in a worker",
    "app/follows/prepared_video.py": "in a worker",
    "app/evidence/explainer.py": "in a process of its own",
    "app/exchange/dataset.py": "on the command line",
    "app/check/report.py": "on the command line",
    "app/labels/pictures.py": "pictures of labels: small PNG files, whose size is read before they are",
    "app/scene3d/service.py": "what the server has drawn itself",
}
"""Modules that decode videos or pictures, and where: never what is large or of any kind in the server itself."""


def test_modules_that_decode_videos() -> None:
    found = {
        path.relative_to(ROOT).as_posix()
        for path in SOURCES
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and ast.unparse(node.func) in DECODING
    }
    assert found == set(DECODERS)


@pytest.mark.parametrize(
    "text",
    [
        "from tsr_engine.io.video_probe import video_sha256",
        "import av",
        "import cv2\ncv2.VideoCapture(x)",
        "open_video(Path(question.video))",
        "open_video(path, limits=limits)",
        "check_file(path)",
        "RunRequest(Path(video.path))",
    ],
)
def test_offences_are_found(text: str) -> None:
    assert offences(text)
