"""Annotation files and bundles, and randomly damaged copies of them."""

from __future__ import annotations

import hashlib
import io
import json
import random
import zipfile
from collections.abc import Callable

__all__ = ["damaged", "damaged_archive", "fix_manifest", "small_files", "zipped"]

BREAKING_VALUES = (
    *(b"NaN", b"-1", b"9" * 40, b"1e999", b"\0", b"<!DOCTYPE a>", b"\xff\xfe", b'"', b"../", b"<", b"\n"),
    *(b"null", b"[]", b"{}", b"[" * 500, b"true", b"1e-400", b"\xed\xa0\x80", b"-9223372036854775809", b"&a;", b","),
)
"""Values that have broken parsers."""


def zipped(files: dict[str, bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return out.getvalue()


def small_files() -> dict[str, bytes]:
    """Small files by name, made without the engine."""
    rows = "".join(f"{frame},{track},{10 + frame},10,20,20,1,1,1\n" for track in (1, 2) for frame in range(1, 70))
    table = "".join(f"{frame},{track},{10 + frame},10,{30 + frame},30,14\n" for track in (1, 2) for frame in range(70))
    box = '<box frame="{}" xtl="{}" ytl="10" xbr="60" ybr="30" outside="0" occluded="0" keyframe="1"/>'
    tracks = "".join(
        f'<track id="{i}" label="stop">{box.format(3, 20 + i)}{box.format(60, 30 + i)}</track>' for i in range(5)
    )
    return {
        "rows.zip": zipped({"gt/gt.txt": rows.encode()}),
        "rows.csv": b"frame,track_id,x1,y1,x2,y2,class_id\n" + table.encode(),
        "a.xml": f"<annotations><version>1.1</version>{tracks}</annotations>".encode(),
    }


def damaged(content: bytes, rng: random.Random) -> bytes:
    """The bytes with parts flipped, removed, doubled, or replaced by values that break parsers."""
    data = bytearray(content)
    for _ in range(rng.randint(1, 6)):
        at = rng.randrange(len(data) + 1)
        what = rng.randrange(4)
        if what == 0 and at < len(data):
            data[at] ^= 1 << rng.randrange(8)
        elif what == 1:
            del data[at : at + rng.randint(1, 200)]
        elif what == 2:
            data[at:at] = data[at : at + rng.randint(1, 2000)]
        else:
            data[at : at + 3] = rng.choice(BREAKING_VALUES)
    return bytes(data) or b"x"


def damaged_archive(
    content: bytes, rng: random.Random, repair: Callable[[dict[str, bytes]], None] = lambda _: None
) -> bytes:
    """A sound archive with one damaged file; now and then the archive itself is damaged.

    Args:
        content: a ZIP archive.
        rng: source of randomness.
        repair: corrects the files after the damage, such as the sums of a manifest.
    """
    if rng.random() < 0.2:
        return damaged(content, rng)
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    name = rng.choice([name for name in files if not name.endswith("/")])
    files[name] = damaged(files[name], rng)
    repair(files)
    return zipped(files)


def fix_manifest(files: dict[str, bytes]) -> None:
    """Correct the sizes and sums in a bundle's manifest, if it is still readable."""
    try:
        manifest = json.loads(files["manifest.json"])
        for entry in manifest["files"]:
            content = files[entry["name"]]
            entry["size"], entry["sha256"] = len(content), hashlib.sha256(content).hexdigest()
    except (KeyError, TypeError, ValueError):
        return
    files["manifest.json"] = json.dumps(manifest).encode()
