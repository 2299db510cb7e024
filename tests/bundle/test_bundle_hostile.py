"""Hostile and damaged bundles are refused in one sentence, and nothing is written outside the folder."""

from __future__ import annotations

import hashlib
import json
import random
import stat
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests import toy_pipeline
from tests.bundle.tracked_drive import TrackedDrive
from tsr_engine.bundle import BundleReplay, bundle_params, open_bundle, replay_bundle
from tsr_engine.cli.main import run
from tsr_engine.errors import ImportFormatError, TsrError
from tsr_engine.evidence import ResultRow

Content = dict[str, bytes]

LONG_VALUE = random.Random(0).randbytes(100_000).hex().encode()
"""A value that Python's reader of CSV refuses, and that an archive does not pack small."""


def rewritten(plain: Path, out: Path, change: Callable[[Content], None], *, honest: bool = True) -> Path:
    """A copy with other files; ``honest``: the manifest has their hashes."""
    with zipfile.ZipFile(plain) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    change(content)
    if honest and len(content.get("manifest.json", b"")) > 10:
        manifest = json.loads(content["manifest.json"])
        files = [(name, data) for name, data in sorted(content.items()) if name != "manifest.json"]
        manifest["files"] = [
            {"name": name, "size": len(data), "sha256": hashlib.sha256(data).hexdigest()} for name, data in files
        ]
        if "clip.mp4" in content:
            manifest["clip"]["sha256"] = hashlib.sha256(content["clip.mp4"]).hexdigest()
        content["manifest.json"] = json.dumps(manifest).encode()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    return out


def manifest_with(**values: Any) -> Callable[[Content], None]:
    def change(content: Content) -> None:
        manifest = json.loads(content["manifest.json"])
        for path, value in values.items():
            place = manifest
            *front, last = path.split("__")
            for name in front:
                place = place[name]
            place[last] = value
        content["manifest.json"] = json.dumps(manifest).encode()

    return change


def replace_file(name: str, data: bytes) -> Callable[[Content], None]:
    return lambda content: content.__setitem__(name, data)


def remove_file(name: str) -> Callable[[Content], None]:
    return lambda content: content.__delitem__(name)


def cut_frames(content: Content) -> None:
    content["frames.csv"] = b"\n".join(content["frames.csv"].splitlines()[:-5]) + b"\n"


def replayed(drive: TrackedDrive, path: Path) -> BundleReplay:
    with open_bundle(path) as bundle:
        params, _ = bundle_params(bundle)
        return replay_bundle(bundle, params, toy_pipeline.components(params))


def error_message(path: Path) -> str:
    with pytest.raises(ImportFormatError) as caught, open_bundle(path):
        pass
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (remove_file("manifest.json"), "is not a bug bundle: manifest.json is missing"),
        (remove_file("clip.mp4"), "clip.mp4 is missing"),
        (remove_file("evidence/evidence.sqlite"), "evidence/evidence.sqlite is missing"),
        (remove_file("expectation.json"), "expectation.json is missing"),
        (replace_file("manifest.json", b"{"), "is not JSON"),
        (replace_file("manifest.json", b"[]"), "does not state its version"),
        (manifest_with(bundle=2), "format 2, this version reads format 1. Update tsr"),
        (manifest_with(bundle=0), "format 0"),
        (manifest_with(frames__stop=10**9), "at most 3000"),
        (manifest_with(frames__first=-1), "frames.first"),
        (manifest_with(clip__file="../../etc/passwd"), "clip.file"),
        (manifest_with(clip__width=16384, clip__height=16385), "clip.height"),
        (manifest_with(clip__offset=1), "expected frame 3"),
        (manifest_with(run__interval=0), "run.interval"),
        (replace_file("output.csv", b"nothing\n"), "output.csv, line 1"),
        (replace_file("output.csv", b""), "output.csv, line 1"),
        (
            replace_file("output.csv", b",".join(map(str.encode, ResultRow._fields)) + b"\n" + LONG_VALUE),
            "output.csv, line 2",
        ),
        (
            replace_file("expectation.json", b'{"format": 1, "signs": {"s": {"frames": [9], "boxes": [[0,0,1,1]]}}}'),
            "not in the",
        ),
        (cut_frames, "frames.csv lists 62 frames, expected 67"),
        (replace_file("frames.csv", b"frame\n3,x,0,\n"), "frames.csv, line 2"),
        (replace_file("frames.csv", b"frame\n" + LONG_VALUE), "frames.csv, line 2"),
    ],
)
def test_the_content_must_be_a_bundle(plain: Path, tmp_path: Path, change: Any, words: str) -> None:
    assert words in error_message(rewritten(plain, tmp_path / "bad.zip", change))


def test_hashes_are_checked(plain: Path, tmp_path: Path) -> None:
    other = rewritten(plain, tmp_path / "a.zip", replace_file("output.csv", b"nothing\n"), honest=False)
    assert "output.csv is not the file that manifest.json names" in error_message(other)
    more = rewritten(plain, tmp_path / "b.zip", replace_file("extra.txt", b"hello"), honest=False)
    assert "'extra.txt' is not in its manifest.json" in error_message(more)


def test_archives_with_paths_outside_are_refused(plain: Path, tmp_path: Path) -> None:
    for name in ("../escaped.txt", "/escaped.txt", "a/../../escaped.txt", "C:\\escaped.txt"):
        path = rewritten(plain, tmp_path / "slip.zip", replace_file(name, b"out"))
        assert "the entry" in error_message(path)
    link = zipfile.ZipInfo("link")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    with zipfile.ZipFile(tmp_path / "link.zip", "w") as archive:
        archive.writestr(link, "/etc/passwd")
    assert "is a link" in error_message(tmp_path / "link.zip")
    assert not list(tmp_path.rglob("escaped*"))


def test_archive_bombs_are_refused(plain: Path, tmp_path: Path) -> None:
    assert "times its packed size" in error_message(
        rewritten(plain, tmp_path / "a.zip", replace_file("note.txt", bytes(40 << 20)))
    )
    nested = (tmp_path / "a.zip").read_bytes()
    assert "an archive within" in error_message(rewritten(plain, tmp_path / "b.zip", replace_file("more.bin", nested)))


def test_other_files_are_refused(tmp_path: Path, plain: Path) -> None:
    (tmp_path / "text.zip").write_text("hello")
    assert "not a ZIP archive" in error_message(tmp_path / "text.zip")
    (tmp_path / "half.zip").write_bytes(plain.read_bytes()[:5000])
    assert "half.zip" in error_message(tmp_path / "half.zip")
    assert "There is no bundle at" in error_message(tmp_path / "none.zip")
    (tmp_path / "drive.mp4").write_text("hello")
    assert "or the evidence folder of a run" in error_message(tmp_path / "drive.mp4")


@pytest.mark.parametrize("clip", [b"", b"#EXTM3U\nfile:///etc/passwd\n", b"\0\0\0\x18ftypmp42" + bytes(400)])
def test_hostile_videos_are_refused(drive: TrackedDrive, plain: Path, tmp_path: Path, clip: bytes) -> None:
    path = rewritten(plain, tmp_path / "video.zip", replace_file("clip.mp4", clip))
    with pytest.raises(TsrError) as caught:
        replayed(drive, path)
    assert caught.value.exit_code == 3
    assert "tsr-bundle-" not in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_clip_of_another_video_is_refused(drive: TrackedDrive, plain: Path, tmp_path: Path) -> None:
    other = toy_pipeline.write_drive(tmp_path / "short.mp4", 20).read_bytes()
    path = rewritten(plain, tmp_path / "video.zip", replace_file("clip.mp4", other))
    with pytest.raises(TsrError, match="ends after 17 of 67 frames"):
        replayed(drive, path)


def test_damaged_evidence_skips_only_the_comparison(drive: TrackedDrive, plain: Path, tmp_path: Path) -> None:
    path = rewritten(
        plain, tmp_path / "old.zip", replace_file("evidence/evidence.sqlite", b"SQLite format 3\0" + bytes(5000))
    )
    report = replayed(drive, path)
    assert report.identical is None
    assert report.verdict == "unchanged"


def test_the_command_line_prints_one_line(plain: Path, tmp_path: Path, capfd: Any) -> None:
    path = rewritten(plain, tmp_path / "slip.zip", replace_file("../x", b""))
    assert run(["replay", str(path)]) == 3
    reported = capfd.readouterr()
    assert reported.out == ""
    assert reported.err.count("\n") == 1
    assert "leads out of its folder" in reported.err
