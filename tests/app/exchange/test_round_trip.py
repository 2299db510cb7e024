"""The bundled drive through every format over HTTP: tracked, corrected, exported and imported unchanged."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from sample_videos import SHIPPED
from tests.app.exchange.exchange_client import ExchangeClient, assert_same_track, clipped_to_picture
from tests.app.inline_worker import run_jobs
from tests.app.jobs.job_server import KNOWN_FOCUS
from tests.app.toy_server import Server
from tsr_engine.exchange.dataset import Track
from tsr_engine.exchange.registry import FORMATS

FIRST, STOP = 0, 40
MAX_THINNED_ERROR_PX = 0.51
"""Bound of thinning and two decimals, px."""


@dataclass(frozen=True)
class Loss:
    """What a format does not keep."""

    px: float = 0.02
    names: bool = True
    hidden: bool = True


LOSSES = {
    "cvat-video": Loss(MAX_THINNED_ERROR_PX),
    "cvat-images": Loss(),
    "coco": Loss(),
    "yolo": Loss(hidden=False),
    "voc": Loss(),
    "mot": Loss(),
    "datumaro": Loss(MAX_THINNED_ERROR_PX),
    "label-studio": Loss(MAX_THINNED_ERROR_PX, hidden=False),
    "tracks-csv": Loss(),
    "tracks-json": Loss(1e-9),
    "gtsdb": Loss(1.0, names=False, hidden=False),
    "gtsrb": Loss(1.0, hidden=False),
}


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ExchangeClient]:
    """The first frames of the first bundled drive, tracked by the real engine, then corrected."""
    home = tmp_path_factory.mktemp("drive") / "home"
    made = ExchangeClient(Server(home, roots=(SHIPPED[0].video.parent,)), "", "")
    with made.server.client:
        made.video_id = made.post("/api/videos", {"path": str(SHIPPED[0].video)})["id"]
        run_jobs(made.server.context, "import")
        wanted = {"first": FIRST, "stop": STOP, "parameters": KNOWN_FOCUS}
        made.run_id = made.post(f"/api/videos/{made.video_id}/runs", wanted)["id"]
        run_jobs(made.server.context, "track")
        make_corrections(made)
        yield made


def make_corrections(api: ExchangeClient) -> None:
    """Move a box, relabel, hide a stretch, judge, write a note, and draw a track with a gap."""
    key, track = next(iter(api.tracks().items()))
    middle = int(track.frames[len(track.frames) // 2])
    box = (track.boxes[len(track.frames) // 2] + [1.5, 2.25, 2.5, 3.75]).tolist()
    api.edit({"name": "set_box", "key": key, "frame": middle, "box": box}, {key: 0})
    api.edit({"name": "relabel_track", "key": key, "frame": middle, "class_id": 13}, {key: 1})
    api.edit({"name": "set_occluded", "key": key, "frame": middle + 1, "value": True}, {key: 2})
    note = {"name": "add_note", "key": key, "frame": middle, "note_id": "n1", "text": 'bent <sign> & "so"; on'}
    api.edit(note, {key: 3})
    api.edit({"name": "set_review", "key": key, "frame": middle, "review": "accepted"}, {key: 4})
    drawn = {"key": "hdrawn01"}
    api.edit({"name": "create_track", **drawn, "frame": 5, "box": [20, 30, 54, 62], "class_id": 1}, {})
    api.edit({"name": "set_box", **drawn, "frame": 11, "box": [26.5, 33.25, 60, 68]}, {"hdrawn01": 1})
    api.edit({"name": "set_box", **drawn, "frame": 15, "box": [30, 36, 66, 72]}, {"hdrawn01": 2})
    api.edit({"name": "set_outside", **drawn, "frame": 12, "value": True}, {"hdrawn01": 3})


def in_picture(api: ExchangeClient) -> dict[str, Track]:
    """The corrected tracks clipped to the picture."""
    video = api.dataset().videos[0]
    return {track.uid: clipped_to_picture(track, video.width, video.height) for track in video.tracks()}


def test_every_format_is_tried() -> None:
    assert set(LOSSES) == {name for name, known in FORMATS.items() if known.write and known.read}


@pytest.mark.slow
@pytest.mark.parametrize("name", list(LOSSES))
def test_a_corrected_drive_round_trips(drive: ExchangeClient, name: str) -> None:
    loss, wanted = LOSSES[name], in_picture(drive)
    assert len(wanted) >= 2
    pictures = "annotated" if FORMATS[name].needs_pictures else "none"
    output = drive.export(format=name, pictures=pictures)
    assert output["state"] == "complete", output["error"]
    content = drive.download(output)
    file = f"{name}.zip"
    back = drive.import_file(content, "run", name=file)
    found = drive.tracks(back["id"])
    assert back["tracks"] == len(wanted)
    by_place = {(int(t.frames[0]), int(t.frames[-1]), round(float(t.boxes[0, 0]) / 4)): t for t in found.values()}
    assert len(by_place) == len(found)
    for track in wanted.values():
        twin = min(found.values(), key=lambda other: distance(track, other))
        if loss.hidden:
            assert_same_track(twin, track, loss.px)
        else:
            assert_same_track(without_marks(twin), without_marks(track), loss.px)
    again = drive.import_file(content, "annotation", name=file)
    if loss.names and loss.px < 1 and loss.hidden:
        assert (again["same"], again["tracks"]) == (len(wanted), 0)
    for key, track in in_picture(drive).items():
        if key in wanted and loss.hidden:
            assert_same_track(track, wanted[key], max(loss.px, MAX_THINNED_ERROR_PX))
    undo(drive)


def undo(api: ExchangeClient) -> None:
    """Undo the import, so that the next format starts from the corrected run."""
    if api.get(f"/api/runs/{api.run_id}/annotation")["undo"]["name"] == "import":
        api.undo()


def distance(a: Track, b: Track) -> float:
    """Largest distance of the edges of two tracks, px."""
    if not np.array_equal(a.frames, b.frames):
        return float("inf")
    return float(np.abs(a.boxes - b.boxes).max())


def without_marks(track: Track) -> Track:
    """For formats without marks 'occluded'."""
    from dataclasses import replace

    return replace(track, occluded=np.zeros_like(track.occluded))


@pytest.mark.slow
def test_a_file_of_another_library_is_imported(drive: ExchangeClient, tmp_path: Path) -> None:
    """A fresh library has the same video and its own run, and gets our corrections."""
    content = drive.download(drive.export(format="tracks-json"))
    other = ExchangeClient(Server(tmp_path / "home", roots=(SHIPPED[0].video.parent,)), drive.video_id, "")
    with other.server.client:
        other.post("/api/videos", {"path": str(SHIPPED[0].video)})
        run_jobs(other.server.context, "import")
        bare = drive.download(drive.export(format="mot"))
        other.run_id = other.import_file(bare, "run", name="mot.zip")["id"]
        laid = other.import_file(content, "annotation", name="tracks.zip")
        assert laid["tracks"] + laid["same"] == len(in_picture(drive))
        for track in in_picture(drive).values():
            twin = min(other.tracks().values(), key=lambda found: distance(track, found))
            assert_same_track(twin, track, MAX_THINNED_ERROR_PX)
            assert twin.state == track.state
            assert [text for _, text in twin.notes] == [text for _, text in track.notes]
