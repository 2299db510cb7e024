"""Downloaded files are named after their videos."""

from __future__ import annotations

import pytest

from app.outputs.names import file_stem


@pytest.mark.parametrize(
    ("name", "stem"),
    [
        ("drive.mp4", "drive"),
        ("SH4 Köln Straße.mp4", "SH4_Köln_Straße"),
        ("03_c0da85.mp4", "03_c0da85"),
        ("../../etc/passwd", "etc_passwd"),
        ("Run 1. again, longer", "Run_1._again_longer"),
        ("\r\nx\\y\0z", "x_y_z"),
        ("...", "video"),
        ("", "video"),
        ("a" * 99 + ".mkv", "a" * 60),
    ],
)
def test_names_of_downloads(name: str, stem: str) -> None:
    assert file_stem(name, "video") == stem
