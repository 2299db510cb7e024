"""Written videos are readable, complete or absent; a full disk is named."""

from __future__ import annotations

import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from tests import toy_pipeline
from tests.io import video_corpus
from tsr_engine.errors import ExportError, StorageError, UsageError
from tsr_engine.io.video import open_video
from tsr_engine.io.video_writer import VideoWriter


@pytest.mark.parametrize("size", [(96, 64), (97, 64), (96, 65), (121, 67)])
def test_written_pictures_round_trip(tmp_path: Path, size: tuple[int, int]) -> None:
    path = tmp_path / "out.mp4"
    pictures = [video_corpus.draw_code(k, *size) for k in range(12)]
    with VideoWriter(path, *size, Fraction(30000, 1001)) as writer:
        for picture in pictures:
            writer.write(picture)
        assert not path.exists(), "the name appears with the whole video"
    assert writer.frames == 12
    with open_video(path) as video:
        assert (video.width, video.height) == (size[0] + size[0] % 2, size[1] + size[1] % 2)
        frames = list(video.frames())
        assert [video_corpus.read_code(frame.picture) for frame in frames] == list(range(12))
        assert [frame.time for frame in frames] == [Fraction(1001 * k, 30000) for k in range(12)]
        assert video.rate == Fraction(30000, 1001)
        for frame, picture in zip(frames, pictures, strict=True):
            back = frame.picture[: size[1], : size[0]].astype(int)
            assert abs(back - picture).mean() < 8, "colours stay"
        assert not video.warnings
    assert [entry.name for entry in tmp_path.iterdir()] == ["out.mp4"]


def test_the_pixel_aspect_ratio_is_stored(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "v.mp4", 96, 64, Fraction(25), pixel_ratio=Fraction(4, 3)) as writer:
        writer.write(video_corpus.draw_code(7))
    with open_video(tmp_path / "v.mp4") as video:
        assert video.pixel_ratio == Fraction(4, 3)
        assert video_corpus.read_code(video.read(0).picture) == 7


def test_times_of_the_source_are_kept(tmp_path: Path) -> None:
    times = [Fraction(5) + Fraction(t, 1000) for t in (0, 40, 73, 200, 201)]
    with VideoWriter(tmp_path / "v.mp4", 96, 64, Fraction(25)) as writer:
        for k, time in enumerate(times):
            writer.write(video_corpus.draw_code(k), time)
    with open_video(tmp_path / "v.mp4") as video:
        assert [frame.time for frame in video.frames()] == [time - 5 for time in times]


@pytest.mark.parametrize("place", [1, 2, 30, 59])
def test_a_gap_too_long_for_mp4_is_shortened_and_reported(tmp_path: Path, place: int) -> None:
    month, step, most = Fraction(30 * 86400), Fraction(1, 25), Fraction(2**28, 90_000)
    times = [k * step + month * (k >= place) for k in range(60)]
    with VideoWriter(tmp_path / "v.mp4", 96, 64, Fraction(25)) as writer:
        for k, time in enumerate(times):
            writer.write(video_corpus.draw_code(k), time)
    assert writer.warnings == ("v.mp4 has 1 gap in time cut to 49 minutes, which is what an MP4 can hold.",)
    with open_video(tmp_path / "v.mp4") as video:
        frames = list(video.frames())
    assert [video_corpus.read_code(frame.picture) for frame in frames] == list(range(60))
    assert [frame.time for frame in frames] == [k * step + (most - step) * (k >= place) for k in range(60)]


def test_many_long_gaps_are_written(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "v.mp4", 96, 64, Fraction(25)) as writer:
        for k in range(40):
            writer.write(video_corpus.draw_code(k), k * Fraction(2**28, 90_000))
    assert not writer.warnings
    with open_video(tmp_path / "v.mp4") as video:
        assert [frame.time for frame in video.frames()] == [k * Fraction(2**28, 90_000) for k in range(40)]


def test_an_encoder_error_is_not_reported_as_a_disk_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tsr_engine.io.video_writer.MAX_GAP_TICKS", 2**40)

    def write() -> None:
        with VideoWriter(tmp_path / "v.mp4", 96, 64, Fraction(25)) as writer:
            for k in range(6):
                writer.write(video_corpus.draw_code(k), k * Fraction(30 * 86400))

    with pytest.raises(ExportError, match=r"cannot be written as the video .*v\.mp4: .*leave the video out") as caught:
        write()
    assert "space" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_an_exception_keeps_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "out.mp4"
    path.write_bytes(b"old")

    def fail() -> None:
        with VideoWriter(path, 96, 64, Fraction(25)) as writer:
            writer.write(video_corpus.draw_code(0))
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        fail()
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_equal_pictures_give_equal_bytes(tmp_path: Path) -> None:
    """On processors with AVX-512, x264 reads memory beyond the macroblocks unless told otherwise."""
    random = np.random.default_rng(3)
    pictures, contents = [toy_pipeline.drive_picture(k) for k in range(30)], set()
    for _ in range(16):
        other_memory = [np.full(random.integers(120_000), 255, np.uint8) for _ in range(40)]
        del other_memory[::2]
        with VideoWriter(tmp_path / "x.mp4", 320, 240, Fraction(25)) as writer:
            for picture in pictures:
                other_memory.append(np.full(random.integers(120_000), random.integers(256), np.uint8))
                del other_memory[int(random.integers(len(other_memory)))]
                writer.write(picture)
        contents.add((tmp_path / "x.mp4").read_bytes())
    assert len(contents) == 1


def test_no_frame_leaves_no_file(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "out.mp4", 96, 64, Fraction(25)):
        pass
    assert not list(tmp_path.iterdir())


def test_wrong_use_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="Got 0x64"):
        VideoWriter(tmp_path / "o.mp4", 0, 64, Fraction(25))
    with (
        pytest.raises(UsageError, match=r"\(64, 96, 3\) and type uint8"),
        VideoWriter(tmp_path / "o.mp4", 96, 64, Fraction(25)) as writer,
    ):
        writer.write(np.zeros((64, 95, 3), np.uint8))
    writer.close()
    with pytest.raises(UsageError, match="is closed"):
        writer.write(video_corpus.draw_code(0))


def test_missing_folder(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="No such file or directory"):
        VideoWriter(tmp_path / "absent" / "o.mp4", 96, 64, Fraction(25))


@pytest.mark.parametrize("limit", [0, 400, 3_000, 60_000])
def test_a_file_size_limit(tmp_path: Path, limit: int) -> None:
    """The limit is reached in the header, in the pictures, or only in the index at the end."""
    script = (
        "import resource, signal, sys\nfrom fractions import Fraction\nimport numpy as np\n"
        "from tsr_engine.errors import StorageError\nfrom tsr_engine.io.video_writer import VideoWriter\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "limit = int(sys.argv[2])\nresource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))\n"
        "noise = np.random.default_rng(0)\n"
        "try:\n"
        "    with VideoWriter(sys.argv[1], 96, 64, Fraction(25)) as writer:\n"
        "        for _ in range(60):\n"
        "            writer.write(noise.integers(0, 255, (64, 96, 3), dtype=np.uint8))\n"
        "except StorageError as error:\n    print(error)\n"
    )
    path = tmp_path / "o.mp4"
    result = subprocess.run(
        [sys.executable, "-c", script, str(path), str(limit)], capture_output=True, text=True, check=True
    )
    assert result.stdout.startswith(f"The video {path} was not written: the file would be larger than this process")
    assert result.stderr == ""
    assert not list(tmp_path.iterdir())
