"""JSON read in chunks equals ``json`` for any chunk size, and errors name the line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange import json_stream
from tsr_engine.exchange.json_stream import LIST_START, members, read_members

_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**20), 10**20) | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=6),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=8,
)  # fmt: skip


def gathered(path: Path) -> Any:
    """The whole file, from its pieces."""
    out: dict[str, Any] = {}
    for key, place, value in members(path):
        if place is None:
            out[key] = value
        elif place == LIST_START:
            out[key] = []
        else:
            assert place == len(out[key]) + 1
            out[key].append(value)
    return out


@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    content=st.dictionaries(st.text(min_size=1, max_size=3), _VALUES, max_size=4),
    chunk=st.sampled_from((1, 3, 17, 4 << 20)),
    plain=st.booleans(),
)
def test_the_chunks_give_the_whole(
    content: dict[str, Any], chunk: int, plain: bool, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "pieces.json"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(json_stream, "CHUNK_BYTES", chunk)
        path.write_text(json.dumps(content, ensure_ascii=plain, indent=None if plain else 1), encoding="utf-8-sig")
        assert gathered(path) == content
        path.write_text(json.dumps([content, 1.5e-7, -3]), encoding="utf-8")
        assert gathered(path) == {"": [content, 1.5e-7, -3]}


@pytest.mark.parametrize("chunk", [1, 4 << 20])
@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b'{"a": [1,\n2}', "line 2: is not JSON"),
        (b'{"a": [1,\nInfinity]}', "line 2: Infinity is not a JSON number"),
        (b'{"a":\n1 "b": 2}', "line 2: is not JSON: ',' is missing"),
        (b'{"a": 1,\n"a": 2}', "line 2: has the key 'a' twice"),
        (b'{"a": 1}\n{', "line 2: is not JSON: there is content after"),
        (b"[1,\n2,]", "line 2: is not JSON"),
        (b"{a: 1}", "double quotes"),
        (b"", "line 1: is not JSON"),
        (b'["x",\n"\xe4"]', "line 2: byte 0xe4 is not UTF-8"),
        (b"\xff\xfe[\0]\0", "line 1: is UTF-16"),
        (b"[" * 50_000, "nested too deeply"),
        (b"[" + b"9" * 5000 + b"]", "is not JSON"),
    ],
)
def test_errors_name_the_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, content: bytes, words: str, chunk: int
) -> None:
    if chunk == 1 and (len(content) > 100 or content.startswith(b"\xff")):
        pytest.skip("takes long letter by letter, or needs two bytes to be seen")
    monkeypatch.setattr(json_stream, "CHUNK_BYTES", chunk)
    path = tmp_path / "wrong.json"
    path.write_bytes(content)
    with pytest.raises(ImportFormatError) as caught:
        gathered(path)
    assert str(caught.value).startswith("wrong.json, line ")
    assert words in str(caught.value)


def test_heads_are_found_without_reading_on(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text('{"format": "x", "classes": ["a", "b"], "tracks": [1], "rest": NOT JSON')
    assert read_members(path, ("format", "classes")) == {"format": "x", "classes": ["a", "b"]}
    path.write_text('{"tracks": [1, 2], "format": "x"}')
    assert read_members(path, ("format", "classes")) == {"format": "x"}


def test_a_file_over_the_limit_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text("[1, 2, 3]")
    with pytest.raises(ImportFormatError, match="9 bytes, more than the 4 that are read") as refused:
        list(members(path, limit=4))
    assert refused.value.kind == "too_large"
