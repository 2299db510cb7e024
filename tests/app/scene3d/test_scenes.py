"""The scenes in a viser server: for any run, fast, and with the right response to clicks."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.scene3d.data import DetectionPoints, Scene3dData, Sign
from app.scene3d.prior import Prior
from app.scene3d.scenes.base import SceneContext
from app.scene3d.scenes.volume import MAX_BLOCKS, MAX_CORNERS
from app.scene3d.view import SCENES, View
from app.scene3d.view_state import MODES, Mode, ViewState
from app.scene3d.viser_host import ViserHost
from tsr_engine.detection.prior import SpatialPrior, parzen


def make_data(tracks: int, length: int = 25, spread: int = 40) -> Scene3dData:
    rng = np.random.default_rng(tracks)
    first = np.arange(tracks) * spread
    frame = (first[:, None] + np.arange(length)).ravel()
    track = np.repeat(np.arange(tracks), length)
    centre = rng.uniform([50, 50], [1200, 650], (tracks, 2))[track]
    side = np.tile(np.linspace(12, 60, length), tracks)
    frames = np.arange(max(1, int(frame.max(initial=0)) + 1))
    return Scene3dData(
        run_id="r",
        video_id="v",
        width=1280,
        height=720,
        frames=frames,
        times=frames / 25.0,
        ids=np.arange(tracks) + 7,
        class_id=rng.integers(-1, 43, tracks),
        flagged=rng.random(tracks) < 0.01,
        frame=frame,
        track=track,
        boxes=np.stack([centre[:, 0], centre[:, 1], centre[:, 0] + side, centre[:, 1] + side], axis=1),
        source=rng.integers(0, 3, len(frame)),
        verdict=rng.integers(0, 3, len(frame)),
        signs={n: Sign(f"sign {n}", pictogram=f"gtsrb/{n}" if n % 2 else "") for n in range(43)},
    )


def make_stage(scene: Any, data: Scene3dData, prior: bool = True) -> SceneContext:
    rng = np.random.default_rng(1)
    hits = DetectionPoints(rng.random((300, 2)), rng.random(300), rng.random(300) < 0.5, 300)
    found = Prior(SpatialPrior(parzen(rng.random((50, 2)), 0.1), 1.5), True) if prior else None
    sign = np.full((32, 32, 4), 255, np.uint8)
    return SceneContext(scene, data, lambda: hits, lambda: found, lambda class_id: sign)


PICTURE = np.full((72, 128, 3), 90, np.uint8)


@pytest.fixture(scope="module")
def host() -> Iterator[ViserHost]:
    made = ViserHost("scenes")
    yield made
    made.stop()


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("tracks", [0, 1, 30])
def test_every_scene_of_every_run_is_drawn_moved_and_removed(host: ViserHost, mode: Mode, tracks: int) -> None:
    data = make_data(tracks)
    scene = SCENES[mode](make_stage(host.server.scene, data))
    view_state = ViewState(frame=10, mode=mode, track="m7")
    looks = [scene.draw(view_state, None)]
    scene.show(PICTURE)
    for change in (
        {"frame": 12},
        {"track": None},
        {"colour": "verdict"},
        {"stretch": 2.0},
        {"view": 90.0},
        {"size": 1.2},
    ):
        after = replace(view_state, **change)
        looks.append(scene.draw(after, view_state))
        scene.show(None if "frame" in change else PICTURE)
        view_state = after
    assert all(look.title for look in looks)
    assert f"/{mode}" in host.server.scene._handle_from_node_name
    scene.clear()
    assert not [name for name in host.server.scene._handle_from_node_name if name.startswith(f"/{mode}")]


def test_a_scene_that_could_not_be_drawn_is_made_anew() -> None:
    failures = [OSError("the evidence is locked")]

    def context(scene: Any) -> SceneContext:
        stage = make_stage(scene, make_data(3))
        detections = stage.detections

        def locked_once() -> DetectionPoints:
            if failures:
                raise failures.pop()
            return detections()

        stage.detections = locked_once
        return stage

    view = View(make_data(3), context, lambda frame: PICTURE, ViewState(mode="prior"), lambda mode: None, "run")
    try:
        assert view.wait(60)
        assert not failures
        assert view.gui.legend.content == ""
        view.request(frame=3)
        assert view.wait(60)
        assert "detections are dense" in view.gui.legend.content
    finally:
        view.stop()


def test_a_run_without_a_prior_says_so(host: ViserHost) -> None:
    scene = SCENES["prior"](make_stage(host.server.scene, make_data(2), prior=False))
    look = scene.draw(ViewState(mode="prior"), None)
    scene.clear()
    assert "no spatial prior" in look.notes[0]


def test_the_metric_scene_states_its_assumptions(host: ViserHost) -> None:
    scene = SCENES["drive"](make_stage(host.server.scene, make_data(2)))
    look = scene.draw(ViewState(mode="drive", view=90.0, size=0.7), None)
    scene.clear()
    assert "90°" in look.notes[0]
    assert "f = 640 px" in look.notes[0]
    assert "0.7 times" in look.notes[0]
    assert "corrections are not drawn" in look.notes[-1]


def test_a_click_on_a_block_names_its_track_and_frame(host: ViserHost) -> None:
    picked = []
    data = make_data(3)
    stage = make_stage(host.server.scene, data)
    stage.on_pick = lambda track, frame: picked.append((track, frame))
    scene: Any = SCENES["volume"](stage)
    scene.draw(ViewState(frame=40 + 12, track="m7"), None)
    handle = scene.blocks
    callbacks = [entry.callback if hasattr(entry, "callback") else entry for entry in handle._impl.click_cb]

    class Click:
        instance_index = 0

    for callback in callbacks:
        callback(Click())
    position = np.array(handle.batched_positions[0])
    scene.clear()
    assert len(picked) == 1
    track, frame = picked[0]
    row = int(np.flatnonzero((data.track == track) & (data.frame == frame))[0])
    positions = scene.volume.positions(data.boxes[[row]], data.seconds(data.frame[[row]]))
    assert np.allclose(positions[0], position, atol=1e-4)


@pytest.mark.parametrize("tracks", [500, 5000])
def test_many_tracks_stay_within_the_limits_of_a_browser(host: ViserHost, tracks: int) -> None:
    data = make_data(tracks)
    scene: Any = SCENES["volume"](make_stage(host.server.scene, data))
    began = time.monotonic()
    view_state = ViewState(frame=tracks * 20, track="m9")
    scene.draw(view_state, None)
    whole = time.monotonic() - began
    lines = host.server.scene._handle_from_node_name["/volume/lines"]
    assert len(lines.points) <= MAX_CORNERS + 2 * tracks
    assert 0 < len(scene.blocks.batched_positions) <= MAX_BLOCKS
    began = time.monotonic()
    for step in range(10):
        after = replace(view_state, frame=view_state.frame + 1 + step)
        scene.draw(after, view_state)
        view_state = after
    each = (time.monotonic() - began) / 10
    scene.clear()
    assert whole < 20
    assert each < 5


def test_most_steps_do_not_redraw_the_lines(host: ViserHost) -> None:
    scene: Any = SCENES["volume"](make_stage(host.server.scene, make_data(300)))
    view_state, drawn = ViewState(frame=3000, stretch=30.0), set()
    scene.draw(view_state, None)
    for frame in range(3000, 3600, 10):
        after = replace(view_state, frame=frame)
        scene.draw(after, view_state)
        view_state = after
        first, last = scene.frame_range
        assert first <= frame <= last
        drawn.add(scene.frame_range)
    scene.clear()
    assert len(drawn) <= 4
