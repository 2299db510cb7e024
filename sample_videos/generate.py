"""Makes a drive: a video, the exact ground truth of its signs, and facts about it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from sample_videos.drive import Drive
from sample_videos.encode import Encoder
from sample_videos.ground_truth import MIN_FACE_PX, MIN_VISIBILITY, Row, write_csv, write_json
from sample_videos.render import FIELD_OF_VIEW, HEIGHT, Renderer
from sample_videos.scenarios import SCENARIOS, Scenario
from sample_videos.scenery import build
from tsr_engine.json_shapes import JsonObject

Progress = Callable[[int, int], None]


class SamplePaths(NamedTuple):
    """Files that `generate` wrote.

    Attributes:
        video: MP4, H.264.
        truth: CSV of the exact boxes.
        facts: JSON: seed, camera, signs, distractors, events.
    """

    video: Path
    truth: Path
    facts: Path


def _runs(frames: list[int]) -> list[tuple[int, int]]:
    """First and last frame of each run of frame numbers; gaps below 4 frames are bridged."""
    runs: list[tuple[int, int]] = []
    for frame in frames:
        if runs and frame - runs[-1][1] <= 4:
            runs[-1] = (runs[-1][0], frame)
        else:
            runs.append((frame, frame))
    return runs


def _events(drive: Drive, renderer: Renderer, rows: list[Row], glare: list[float], count: int) -> list[JsonObject]:
    """Kinds of stress and their frames."""
    fps, (width, height) = renderer.fps, renderer.size
    events: list[JsonObject] = []
    for t, strength in drive.bumps:
        last = min(count - 1, round((t + 0.7) * fps))
        events.append({"kind": "bump", "first": round(t * fps), "last": last, "strength": round(strength, 2)})
    events += [
        {"kind": "glare", "first": a, "last": b} for a, b in _runs([k for k, seen in enumerate(glare) if seen > 0.25])
    ]
    if drive.bridge is not None:
        below = [k for k in range(count) if drive.bridge[0] - 2 < drive.distance(k / fps) < drive.bridge[1]]
        events += [{"kind": "bridge_shadow", "first": a, "last": b} for a, b in _runs(below)]
    for sign in drive.signs:
        whole = [
            r for r in rows if r.track_id == sign.track_id and min(r.x1, r.y1) > 0 and r.x2 < width and r.y2 < height
        ]
        covered = [r.frame for r in whole if r.visibility < 0.9 and min(r.x2 - r.x1, r.y2 - r.y1) >= MIN_FACE_PX]
        events += [{"kind": "occlusion", "first": a, "last": b, "track_id": sign.track_id} for a, b in _runs(covered)]
    if drive.weather.name in ("dusk", "low_sun", "overcast"):
        events.append({"kind": drive.weather.name, "first": 0, "last": count - 1})
    return sorted(events, key=lambda e: (e["first"], e["kind"]))


def _facts(
    chosen: Scenario, drive: Drive, renderer: Renderer, rows: list[Row], glare: list[float], count: int
) -> JsonObject:
    """The facts except the drive's name, scenario and seed."""
    seen = {r.track_id for r in rows}
    signs = [
        {"track_id": s.track_id, "class_id": s.class_id, "s_m": round(s.s, 2), "d_m": round(s.d, 2), "width_m": s.width}
        for s in drive.signs
        if s.track_id in seen
    ]
    return {
        "frames": count,
        "width": renderer.size[0],
        "height": renderer.size[1],
        "fps": renderer.fps,
        "weather": drive.weather.name,
        "camera": {
            "focal_px": round(renderer.focal, 3),
            "height_m": HEIGHT,
            "field_of_view_deg": FIELD_OF_VIEW,
            "speed_m_s": chosen.speed,
        },
        "signs": signs,
        "events": _events(drive, renderer, rows, glare, count),
        "distractors": drive.distractors,
        "truth": {
            "box": "tight box of the whole face, pixel edges, cut to the picture, at the middle of the exposure",
            "ignore": f"1 below {MIN_FACE_PX:g} px or with less than {MIN_VISIBILITY:g} of the face in sight",
        },
    }


def _check(seconds: float, size: tuple[int, int], fps: int) -> None:
    if not 0.04 <= seconds <= 3600:
        raise ValueError(f"seconds must be within 0.04 to 3600. Got {seconds:g}.")
    if min(size) < 64 or size[0] % 2 or size[1] % 2 or max(size) > 4096:
        raise ValueError(
            f"size must be two even numbers within 64 to 4096, for example 1280x720. Got {size[0]}x{size[1]}."
        )
    if not 1 <= fps <= 120:
        raise ValueError(f"fps must be within 1 to 120. Got {fps}.")


def generate(
    out_dir: str | Path,
    seconds: float = 12.0,
    seed: int = 0,
    size: tuple[int, int] = (1280, 720),
    fps: int = 25,
    progress: Progress | None = None,
    *,
    scenario: str | None = None,
    name: str | None = None,
    crf: int = 24,
) -> SamplePaths:
    """Render a drive with exact ground truth.

    The same arguments give the same bytes on the same machine with the same libraries.

    Args:
        out_dir: Output folder; made if it is missing.
        seconds: Length of the drive.
        seed: Random seed; not negative.
        size: Width and height, both even.
        fps: Frames per second.
        progress: Called with (frames done, total frames) after each frame.
        scenario: One of `SCENARIOS`; None: chosen by the seed.
        name: Stem of the files; None: the scenario's name and the seed.
        crf: Constant rate factor of x264.

    Returns:
        The paths written.

    Raises:
        ValueError: An argument is out of range, or the scenario is unknown.
        OSError: The folder or a file cannot be written.
    """
    _check(seconds, size, fps)
    if seed < 0:
        raise ValueError(f"seed must be 0 or more. Got {seed}.")
    chosen = _choose(scenario, seed)
    drive = build(chosen, seconds, np.random.default_rng([seed, 1]))
    renderer = Renderer(drive, size, fps, seed)
    folder = Path(out_dir)
    folder.mkdir(parents=True, exist_ok=True)
    stem = name or f"{chosen.name}_{seed}"
    paths = SamplePaths(folder / f"{stem}.mp4", folder / f"{stem}.csv", folder / f"{stem}.json")
    count = max(1, round(seconds * fps))
    rows: list[Row] = []
    glare: list[float] = []
    # an older drive of that name stays complete until it is replaced
    with TemporaryDirectory(prefix=".drive-", dir=folder) as place:
        making = SamplePaths(*(Path(place) / path.name for path in paths))
        with Encoder(making.video, size, fps, crf) as encoder:
            for number in range(count):
                moment = renderer.frame(number)
                encoder.add(moment.picture)
                rows += moment.rows
                glare.append(moment.glare)
                if progress is not None:
                    progress(number + 1, count)
        write_csv(making.truth, rows)
        write_json(
            making.facts,
            {"clip": stem, "scenario": chosen.name, "seed": seed} | _facts(chosen, drive, renderer, rows, glare, count),
        )
        for made, wanted in zip(making, paths, strict=True):
            made.replace(wanted)
    return paths


def _choose(scenario: str | None, seed: int) -> Scenario:
    """The scenario by name, or by seed."""
    if scenario is None:
        names = sorted(SCENARIOS)
        return replace(SCENARIOS[names[seed % len(names)]])
    if scenario not in SCENARIOS:
        raise ValueError(f"scenario must be one of {', '.join(sorted(SCENARIOS))}. Got {scenario!r}.")
    return SCENARIOS[scenario]
