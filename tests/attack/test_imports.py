"""Small archives that unpack to very many tracks and boxes, and clients that leave (finding F3)."""

from __future__ import annotations

import signal
import threading
import time
import tracemalloc
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.exchange.dataset import LABELS
from tests.app.toy_home import ToyHome, make_home
from tests.attack.damage import zipped
from tests.attack.many_tracks import FRAMES, MAX_MEMORY_MB, cvat_archive, mot_archive
from tests.attack.server_process import ServerProcess, command_line, start_server
from tests.waiting import TIME_FACTOR, time_limit, wait_until
from tsr_engine.errors import ImportFormatError
from tsr_engine.evaluation.matching import box_pairs
from tsr_engine.exchange.dataset import DatasetVideo
from tsr_engine.exchange.formats import ImportLimits, ImportTarget
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.load import read_dataset
from tsr_engine.track_table import TrackTable

pytestmark = pytest.mark.slow
LOWER_LIMITS = {"TSR_IMPORT_MAX_TRACKS": "5000", "TSR_IMPORT_MAX_BOXES": "250000"}
"""A quarter of what is let in otherwise: ``tests.attack.measure`` goes to the limits themselves."""


@pytest.fixture(scope="module")
def toy(tmp_path_factory: pytest.TempPathFactory) -> ToyHome:
    """A home with a tracked drive."""
    home = make_home(tmp_path_factory.mktemp("imports"), FRAMES)
    home.evidence.close()
    home.database.close()
    return home


def fails(server: ServerProcess, path: str, content: bytes) -> None:
    with suppress(OSError):
        server.request(path, content)


def target(limits: ImportLimits | None = None) -> ImportTarget:
    video = DatasetVideo("d.mp4", "0" * 64, 320, 240, FRAMES, Fraction(25), None, True, lambda: iter(()), stop=FRAMES)
    return ImportTarget(video, LABELS, limits=limits or ImportLimits())


def test_memory_and_latency_stay_bounded_during_imports(toy: ToyHome) -> None:
    """Many tracks, boxes, or interpolated boxes are refused, or imported by another process."""
    attacks = {
        "tracks": mot_archive(25_000),
        "boxes": mot_archive(5_000, 60),
        "between key frames": cvat_archive(4_800),
        "as many as are let in": mot_archive(4_000),
    }
    with start_server(toy.settings.home, LOWER_LIMITS) as server, server.monitored():
        for name, content in attacks.items():
            path = f"/api/videos/{toy.video_id}/imports?as=annotation&run={toy.run_id}&file=a.zip&name=a.zip"
            began = time.monotonic()
            status, answer = server.request(path, content)
            reported = answer if status != 201 else answer["tracks"]
            assert (status, name) in ((413, name), (201, "as many as are let in")), (name, reported)
            assert time.monotonic() - began < time_limit(20), name
    assert server.memory < MAX_MEMORY_MB
    late = [round(wait, 2) for wait in server.waits if wait > time_limit(0.5)]
    assert not late, late


def test_an_import_ends_on_cancel_disconnect_and_server_stop(toy: ToyHome) -> None:
    content = mot_archive(10_000, 50)
    path = f"/api/videos/{toy.video_id}/imports?as=run&file=a.zip&name=a.zip"
    with start_server(toy.settings.home, forked=True) as server:
        name, answered = "c" * 32, list[tuple[int, Any]]()
        asked = threading.Thread(target=lambda: answered.append(server.request(f"{path}&progress={name}", content)))
        asked.start()
        wait_until(lambda: server.request(f"/api/imports/{name}")[1].get("boxes", 0) > 0)
        assert server.request(f"/api/imports/{name}")[1]["step"] == "reading"
        assert server.request(f"/api/imports/{name}/cancel", b"")[0] == 202
        asked.join(time_limit(5))
        status, said = answered[0]
        assert (status, said["error"]["code"]) == (503, "cancelled")
        assert "Nothing was imported" in said["error"]["message"]
        assert server.request(f"/api/imports/{name}")[0] == server.request(f"/api/imports/{name}/cancel", b"")[0] == 404
        wait_until(lambda: not server.sandboxes(), time_limit(3))
        with pytest.raises(OSError, match="timed out"):
            server.request(path, content, timeout=2)
        wait_until(lambda: not server.sandboxes(), time_limit(3))
        threading.Thread(target=fails, args=(server, path, content), daemon=True).start()
        wait_until(server.sandboxes, time_limit(10))
        sandboxes = server.sandboxes()
        began = time.monotonic()
        server.process.send_signal(signal.SIGTERM)
        server.process.wait(time_limit(10))
        assert time.monotonic() - began < time_limit(2)
        wait_until(lambda: not any(command_line(one) for one in sandboxes), time_limit(2))


def test_reading_time_grows_with_the_number_of_rows(tmp_path: Path) -> None:
    """CPU time of this process, independent of other load."""

    def computing(tracks: int) -> float:
        path = tmp_path / f"{tracks}.zip"
        path.write_bytes(mot_archive(tracks))
        began = time.process_time()
        assert sum(1 for _ in read_dataset(path, target(), scratch=tmp_path).videos[0].tracks()) == tracks
        return time.process_time() - began

    few, many = computing(5_000), computing(50_000)
    assert many < 20 * few
    assert many < 2 * TIME_FACTOR


def test_many_tracks_of_one_name_are_numbered_quickly(tmp_path: Path) -> None:
    """The search for a free number continues where the previous one ended."""
    validator = ImportValidator(target())
    began = time.process_time()
    for k in range(30_000):
        validator.box(validator.unique_uid("same", "a", k), k % FRAMES, (1, 1, 9, 9), 0, file="a", line=k)
    assert time.process_time() - began < time_limit(3)
    assert len(validator) == 30_000


def test_limits_on_tracks_and_boxes_hold(tmp_path: Path) -> None:
    path = tmp_path / "a.zip"
    path.write_bytes(mot_archive(50, 2))
    read_dataset(path, target(ImportLimits(50, 100)))
    for limits, what in ((ImportLimits(49, 100), "more than 49 tracks"), (ImportLimits(50, 99), "more than 99 boxes")):
        with pytest.raises(ImportFormatError, match=what) as caught:
            read_dataset(path, target(limits))
        assert caught.value.kind == "too_large"
    path.write_bytes(cvat_archive(10))
    read_dataset(path, target(ImportLimits(10, 10 * FRAMES)))
    with pytest.raises(ImportFormatError, match="between its key frames"):
        read_dataset(path, target(ImportLimits(10, 10 * FRAMES - 1)))


def test_matching_many_tracks_takes_bounded_memory() -> None:
    """All tracks share one frame, so the pairs are compared in blocks."""

    def table(count: int, shift: float) -> TrackTable:
        places = [(float(10 * (i % 300)) + shift, float(10 * (i // 300))) for i in range(count)]
        boxes = np.array([[x, y, x + 8, y + 8] for x, y in places])
        none = np.zeros(count, np.int64)
        return TrackTable(none, np.arange(count), boxes)

    tracemalloc.start()
    pairs = box_pairs(table(4000, 0), table(4000, 1), 0.5)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert pairs.a.tolist() == pairs.b.tolist() == list(range(4000))
    assert peak < 300 << 20


def test_an_archive_with_negative_offsets_is_refused_as_damaged(tmp_path: Path) -> None:
    """Negative offsets raise an ``OSError``, which must not be reported as a full disk."""
    good = zipped({"gt/gt.txt": b"1,1,10,10,20,20,1,1,1\n"})
    for where in (slice(0, 40), slice(0, 3)):
        path = tmp_path / "a.zip"
        data = bytearray(good)
        del data[where]
        path.write_bytes(data)
        with pytest.raises(ImportFormatError, match="archive is damaged"):
            read_dataset(path, target(), scratch=tmp_path)
