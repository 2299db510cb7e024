"""Readers are reused, their number is limited, and none reads a file that was replaced."""

from __future__ import annotations

import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from app.evidence.reader_pool import ReaderPool
from tsr_engine.evidence.reader import EvidenceReader


def test_a_reader_is_reused_between_requests(home: Any) -> None:
    pool = ReaderPool()
    with pool.reading(home.folder) as first, pool.reading(home.folder) as second:
        assert first is not second
    with pool.reading(home.folder) as third:
        assert third in (first, second)
    pool.close()


def test_a_replaced_store_is_opened_again(home: Any, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    shutil.copytree(home.folder, folder)
    pool = ReaderPool()
    with pool.reading(folder) as before:
        pass
    shutil.rmtree(folder)
    shutil.copytree(home.folder, folder)
    with pool.reading(folder) as after:
        assert after is not before
        assert len(after) == 75
    pool.close()


def test_few_readers_are_kept(home: Any, tmp_path: Path) -> None:
    pool = ReaderPool(max_folders=2, max_readers=1)
    folders = [shutil.copytree(home.folder, tmp_path / name) for name in "abc"]

    def two_readers(folder: Path) -> set[EvidenceReader]:
        with pool.reading(folder) as first, pool.reading(folder) as second:
            return {first, second}

    before = [two_readers(folder) for folder in folders]
    assert [len(before[k] & two_readers(folders[k])) for k in (1, 2, 0)] == [1, 1, 0]
    pool.close()


def test_a_failed_reader_is_not_kept(home: Any) -> None:
    pool = ReaderPool()
    with pytest.raises(KeyError), pool.reading(home.folder) as failed:
        raise KeyError
    with pool.reading(home.folder) as another:
        assert another is not failed
    pool.close()


def test_many_threads_at_once(home: Any) -> None:
    def ask(k: int) -> None:
        for i in range(10):
            assert len(home.evidence.overlays(home.run_id, (k + i) % 40, (k + i) % 40 + 9)) == 10

    with ThreadPoolExecutor(8) as threads:
        list(threads.map(ask, range(8)))
