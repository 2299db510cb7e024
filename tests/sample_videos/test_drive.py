"""A rendered drive: boxes against the rendered faces, determinism, stress, distractors."""

from __future__ import annotations

import json
import pathlib
from typing import Any

import cv2
import numpy as np
import pytest

from sample_videos import SCENARIOS
from sample_videos.camera import look
from sample_videos.drive import Drive
from sample_videos.encode import Encoder
from sample_videos.generate import generate
from sample_videos.linear_canvas import LinearCanvas
from sample_videos.pole_plan import plan_poles
from sample_videos.render import Renderer
from sample_videos.road_path import RoadPath
from sample_videos.scene_objects import View
from sample_videos.scenery import build
from sample_videos.sign_posts import build_sign_post
from sample_videos.weather import WEATHERS
from tests.sample_videos.truth_rows import read_rows
from tsr_engine.pictograms.gtsrb import nominal_width, outline

SIZE = (320, 180)


@pytest.fixture(scope="module")
def road() -> RoadPath:
    return RoadPath(200.0, [(10.0, 120.0, 0.2)])


@pytest.fixture(scope="module")
def town() -> Drive:
    return build(SCENARIOS["low_sun"], 9.0, np.random.default_rng([5, 1]))


@pytest.fixture(scope="module")
def rendered(town: Drive) -> Renderer:
    return Renderer(town, SIZE, 25, 5)


@pytest.fixture(scope="module")
def drive() -> Drive:
    return build(SCENARIOS["country_road"], 2.0, np.random.default_rng(4))


@pytest.fixture(scope="module")
def renderer(drive: Drive) -> Renderer:
    return Renderer(drive, SIZE, 25, 4)


def test_box_is_the_box_of_the_rendered_face(road: RoadPath) -> None:
    """Each sign is painted alone: its coverage has the bounds and the area of the projected outline."""
    rng = np.random.default_rng(2)
    width, height = 960, 540
    poles = [[0], [12, 7], [13], [14], [31], [40], [25, 9]]
    signs = [
        s for k, classes in enumerate(poles) for s in build_sign_post(rng, road, 20.0 + k, 5.0, classes, 1, 0.0)[0]
    ]
    for sign in signs:
        right, forward = road.frame(sign.s)
        for far in (9.0, 14.0, 25.0):
            eye = sign.place - forward * far - right * 2.0
            eye[1] = 1.3
            camera = look(width, height, 850.0, eye, road.heading(sign.s) + 0.02, 0.01, 0.03)
            film, day = LinearCanvas(width, height), WEATHERS["day"]
            view = View(camera, camera, day, film, day.horizon, lambda _: (1.0, 1.0))
            sign.draw(view)
            polygon = sign.polygon(camera)
            assert polygon is not None
            seen = film.watched[0]
            solid = seen.left > 0.5
            columns, rows = np.flatnonzero(solid.any(0)), np.flatnonzero(solid.any(1))
            box = (seen.x + columns[0], seen.y + rows[0], seen.x + columns[-1] + 1, seen.y + rows[-1] + 1)
            assert np.abs(np.array(box) - [*polygon.min(0), *polygon.max(0)]).max() <= 1.0
            assert seen.visibility() > 0.97
            assert seen.left.sum() == pytest.approx(cv2.contourArea(polygon.astype(np.float32)), rel=0.03)


def test_the_width_follows_the_pinhole_camera(road: RoadPath) -> None:
    """A disc of diameter D at depth Z straight ahead is f D / Z wide."""
    rng = np.random.default_rng(0)
    signs, _ = build_sign_post(rng, road, 0.0, 0.0, [2], 1, 0.0)
    sign = signs[0]
    _, forward = road.frame(0.0)
    for z in (6.0, 12.0, 24.0, 48.0):
        camera = look(1280, 720, 1100.0, sign.place - forward * z, road.heading(0.0), 0.0, 0.0)
        polygon = sign.polygon(camera)
        assert polygon is not None
        wide, tall = np.ptp(polygon, axis=0)
        assert tall == pytest.approx(1100.0 * nominal_width(2) / z, rel=0.01)
        assert 0.97 * tall < wide <= 1.01 * tall


def test_frame_has_a_road_a_sky_and_rows(renderer: Renderer) -> None:
    moment = renderer.frame(20)
    assert moment.picture.shape == (SIZE[1], SIZE[0], 3)
    blue, _, red = moment.picture[:40].reshape(-1, 3).mean(0)
    assert blue > red
    road = moment.picture[150:165, 130:190].astype(float)
    assert abs(road[..., 0].mean() - road[..., 2].mean()) < 25
    assert {r.track_id for r in moment.rows} <= {s.track_id for s in renderer.drive.signs}
    assert any(r.visibility > 0.9 for r in moment.rows)


def test_rows_follow_the_camera(renderer: Renderer) -> None:
    """The rows of a frame are the projected outlines at that time."""
    moment = renderer.frame(30)
    camera = renderer.camera(30 / 25)
    for r in moment.rows:
        sign = next(s for s in renderer.drive.signs if s.track_id == r.track_id)
        polygon = sign.polygon(camera)
        assert polygon is not None
        low, high = polygon.min(0), polygon.max(0)
        assert r.x1 == pytest.approx(max(low[0], 0), abs=0.006)
        assert r.y2 == pytest.approx(min(high[1], SIZE[1]), abs=0.006)
        assert r.class_id == sign.class_id


def test_a_hidden_sign_has_low_visibility(town: Drive, rendered: Renderer) -> None:
    """The sign behind the parked van is hidden from afar and fully visible from near."""
    hidden = town.signs[3]
    seen = {}
    for before in (26.0, 9.0):
        number = round(town.time_at(hidden.s - before) * 25)
        rows = {r.track_id: r for r in rendered.frame(number).rows}
        seen[before] = rows[hidden.track_id].visibility
    assert seen[26.0] < 0.5
    assert seen[9.0] > 0.9


def test_a_bridge_darkens_the_picture(town: Drive, rendered: Renderer) -> None:
    assert town.bridge is not None
    middle = town.path.point((town.bridge[0] + town.bridge[1]) / 2, 0.0)
    assert rendered.light_at(middle) == (0.0, 0.16)
    assert rendered.light_at(town.path.point(town.bridge[0] - 60, 0.0)) == (1.0, 1.0)


def test_a_long_drive_has_all_classes() -> None:
    poles = plan_poles(SCENARIOS["country_road"], (500.0, 511.0), 2300.0, np.random.default_rng(0))
    assert {c for pole in poles for c in pole.classes} == set(range(43))
    gaps = np.diff([pole.s for pole in poles])
    assert gaps.min() > 30
    assert not any(491 < pole.s < 527 for pole in poles)
    assert any(len(pole.classes) == 2 for pole in poles)


def test_distractors_have_no_ground_truth(drive: Drive) -> None:
    assert {"poster", "sign_back", "direction"} <= {d["kind"] for d in drive.distractors}
    plates = [thing for thing, _ in drive.things if type(thing).__name__ == "Plate"]
    faces = {id(s.plate) for s in drive.signs}
    assert plates
    assert all(id(plate) not in faces for plate in plates)


def test_outline_fits_the_unit_square() -> None:
    for class_id in range(43):
        assert np.abs(outline(class_id)).max() <= 1.001


def test_same_seed_same_bytes(tmp_path: pathlib.Path) -> None:
    calls: list[tuple[int, int]] = []
    first = generate(
        tmp_path / "a", 0.16, 3, (192, 108), 25, lambda *c: calls.append(c), scenario="overcast_road", name="x"
    )
    again = generate(tmp_path / "b", 0.16, 3, (192, 108), scenario="overcast_road", name="x")
    for one, two in zip(first, again, strict=True):
        assert one.read_bytes() == two.read_bytes()
    assert calls == [(1, 4), (2, 4), (3, 4), (4, 4)]
    facts = json.loads(first.facts.read_text())
    assert facts["frames"] == 4
    assert facts["seed"] == 3
    assert {r.frame for r in read_rows(first.truth)} <= {0, 1, 2, 3}


def test_same_bytes_at_a_width_of_few_macroblocks(town: Drive, tmp_path: pathlib.Path) -> None:
    """On processors with AVX-512, x264 reads memory beyond them unless told otherwise."""
    rng = np.random.default_rng(3)
    renderer = Renderer(town, (160, 90), 10, 3)
    pictures = [renderer.frame(number).picture for number in range(4)]
    contents = set()
    for _ in range(24):
        with Encoder(tmp_path / "x.mp4", (160, 90), 10, 20) as encoder:
            for picture in pictures:
                np.full(rng.integers(200_000), rng.integers(256), np.uint8)  # left behind in freed memory
                encoder.add(picture)
        contents.add((tmp_path / "x.mp4").read_bytes())
    assert len(contents) == 1


@pytest.mark.parametrize(
    ("kwargs", "message"),
    [
        ({"seconds": 0.0}, "seconds must be within"),
        ({"seed": -1}, "seed must be 0 or more"),
        ({"size": (321, 180)}, "size must be two even numbers"),
        ({"fps": 0}, "fps must be within"),
        ({"scenario": "moon"}, "scenario must be one of"),
    ],
)
def test_bad_arguments_are_refused(tmp_path: pathlib.Path, kwargs: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        generate(tmp_path / "never", **kwargs)
    assert not (tmp_path / "never").exists()
