"""Finds the videos, ground truth and tables for `tsr eval tracking`."""

from __future__ import annotations

from pathlib import Path

from tsr_engine.cli.common import say
from tsr_engine.errors import InputError
from tsr_engine.io.video_kinds import VIDEO_SUFFIXES


def find_annotated_videos(sources: list[Path], truth: Path | None) -> list[Path]:
    """The given videos, and those of given folders that have ground truth.

    Raises:
        InputError: a path does not exist, or a folder has no such video.
    """
    videos: list[Path] = []
    for source in sources:
        if source.is_dir():
            inside = sorted(p for p in source.iterdir() if p.suffix.lower() in VIDEO_SUFFIXES)
            annotated = [p for p in inside if _ground_truth_files(p, truth)]
            if not annotated:
                raise InputError(f"{source} has no video with a ground truth CSV. Name its folder with --truth.")
            videos += annotated
        elif source.exists():
            videos.append(source)
        else:
            raise InputError(f"There is no video or folder at {source}. Check the path.")
    return videos


def _ground_truth_files(video: Path, truth: Path | None) -> list[Path]:
    folders = [truth] if truth is not None else [video.parent, video.parent / "gt"]
    return [path for folder in folders if (path := folder / f"{video.stem}.csv").is_file()]


def find_ground_truth(video: Path, truth: Path | None) -> Path:
    """The ground truth table of a video: in the given folder, else beside the video or in ``gt`` there.

    Raises:
        InputError: the table is missing.
    """
    found = _ground_truth_files(video, truth)
    if not found:
        where = str(truth) if truth is not None else f"{video.parent} or its folder gt"
        raise InputError(
            f"There is no ground truth {video.stem}.csv for {video.name} in {where}. Name its folder with --truth."
        )
    return found[0]


def keep_readable(pairs: list[tuple[Path, Path]]) -> list[tuple[Path, Path, tuple[int, int, int]]]:
    """Readable videos with their ground truth, and their frames, width and height; others are reported on stderr.

    Raises:
        InputError: no video is readable.
    """
    from tsr_engine.io.video import open_video

    readable = []
    for video, table in pairs:
        try:
            with open_video(video) as opened:
                readable.append((video, table, (len(opened.table), opened.width, opened.height)))
        except InputError as error:
            if len(pairs) == 1:
                raise
            say(str(error))
    if not readable:
        raise InputError(f"None of the {len(pairs)} videos could be read.")
    return readable


def find_results(video: Path, results: Path) -> Path:
    """The table of a video's tracks: named after the video, or as exports name it.

    Raises:
        InputError: both are missing.
    """
    from tsr_engine.exchange.video_names import safe_stem

    names = dict.fromkeys((f"{video.stem}.csv", f"{safe_stem(video.name)}.csv"))
    for name in names:
        if (results / name).is_file():
            return results / name
    raise InputError(f"There is no {' or '.join(names)} for {video.name} in {results}. Name its folder with --results.")
