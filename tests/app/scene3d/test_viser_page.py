"""viser's page under our content security policy."""

from __future__ import annotations

import base64
import hashlib
import re

import pytest

from app.scene3d import page as page_module
from app.scene3d.page import viser_page
from tsr_engine.errors import StorageError


def test_the_policy_allows_only_the_pages_inline_scripts() -> None:
    page = viser_page()
    text = page.content.decode()
    inline = re.findall(r"<script[^>]*>(.*?)</script>", text, re.DOTALL)
    assert len(inline) == 5
    script = re.search(r"script-src ([^;]*)", page.policy)
    assert script is not None
    for code in inline:
        digest = base64.b64encode(hashlib.sha256(code.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in script[1]
    assert "unsafe-inline" not in script[1]
    assert "'unsafe-eval'" not in script[1]


def test_the_page_connects_to_and_is_framed_by_this_server_only() -> None:
    policy = viser_page().policy
    assert "default-src 'none'" in policy
    assert "connect-src 'self' data: blob:" in policy
    assert "frame-ancestors 'self'" in policy
    assert "http" not in policy
    assert "*" not in policy


def test_the_script_is_unpacked_for_its_hash() -> None:
    text = viser_page().content.decode()
    for script in (page_module.HUSH, page_module.BAR, page_module.AWAKE, page_module.PLAIN):
        text = text.replace(f"<script>{script}</script>", "")
    loader, program = page_module.page_scripts(text)
    assert b"DecompressionStream" in loader
    assert len(program) > 1_000_000
    assert b"WebSocket" in program


def test_another_build_of_the_page_is_refused() -> None:
    with pytest.raises(StorageError, match="unknown structure"):
        page_module.page_scripts("<html><head><script>1</script></head></html>")


@pytest.mark.parametrize("size", [0, 1, 2, 3, 4, 5, 7, 64, 1001])
def test_base_88_is_decoded(size: int) -> None:
    data = hashlib.shake_128(b"seed").digest(size)
    text = ""
    for start in range(0, size, 4):
        group = data[start : start + 4]
        number, digits = int.from_bytes(group, "big"), ""
        for _ in range(len(group) + 1):
            number, digit = divmod(number, 88)
            digits = page_module.ALPHABET[digit] + digits
        text += digits
    assert page_module.from_base88(text) == data
