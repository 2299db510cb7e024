"""Edits are refused outside the frames of their video."""

from __future__ import annotations

from typing import Any

import pytest

from app.edits.documents import OPEN_END, KeyFrame, Note, TrackDoc
from app.errors import Conflict, Invalid
from app.storage.models import Run, Video
from tests.app.edits.edit_services import FRAMES, VIDEO, EditServices
from tests.app.edits.sent_edits import relabel, send


@pytest.mark.parametrize(
    ("raw", "field"),
    [
        ({"name": "set_box", "frame": FRAMES, "box": [0.0, 0.0, 9.0, 9.0]}, "frame"),
        ({"name": "add_note", "frame": OPEN_END, "note_id": "n", "text": "far"}, "frame"),
        ({"name": "interpolate", "frame": 3, "first": FRAMES, "last": FRAMES}, "first"),
        ({"name": "interpolate", "frame": 3, "first": 0, "last": 20_000_000}, "last"),
    ],
)
def test_frames_outside_the_video_are_refused(edits: EditServices, raw: dict[str, Any], field: str) -> None:
    with pytest.raises(Invalid, match=rf"frames 0 to {FRAMES - 1}\. Got \d+\.") as caught:
        send(edits, "1", {"key": "m1", **raw}, {"m1": 0})
    assert (caught.value.field, caught.value.code) == (f"command.{field}", "no_such_frame")
    assert edits.service.log(edits.run, 0) == []
    last = {"name": "set_box", "frame": FRAMES - 1, "key": "m1", "box": [0.0, 0.0, 9.0, 9.0]}
    open_piece = {"track": 1, "first": 0, "last": OPEN_END}  # as a page sends it during the run
    assert send(edits, "2", {**last, "spans": [open_piece]}, {"m1": 0}).docs[0].frames() == [FRAMES - 1]


def test_imported_documents_end_with_the_video(edits: EditServices) -> None:
    drawn = TrackDoc(key="hdrawn01", keys={"0": KeyFrame(box=(0, 0, 9, 9))})
    far = drawn.model_copy(update={"keys": {**drawn.keys, str(FRAMES): KeyFrame(box=(0, 0, 9, 9))}})
    noted = drawn.model_copy(update={"notes": (Note(id="n", frame=FRAMES, text="far", author="ann", time=""),)})
    command = {"name": "import"}

    def first(document: TrackDoc) -> None:
        with edits.database.write() as session:
            run = session.get_one(Run, edits.run)
            edits.bulk.record(session, run, "ann", command, {"hdrawn01": drawn}, {"hdrawn01": document})

    for document in (far, noted):
        with pytest.raises(Invalid, match=f"Track hdrawn01: .* Got {FRAMES}"):
            edits.bulk.put_documents(edits.run, "ann", command, lambda _, d=document: {d.key: d})
        with pytest.raises(Invalid, match="Track hdrawn01"):
            first(document)
    assert edits.documents() == {}
    first(drawn)
    assert edits.documents()["hdrawn01"].has_same_content(drawn)


def test_a_video_being_imported_has_its_known_frames(edits: EditServices) -> None:
    """A bundle's clip is imported after its run."""

    def known(state: str, frames: int | None, stop: int | None) -> None:
        with edits.database.write() as session:
            video = session.get_one(Video, VIDEO)
            video.state, video.frames, session.get_one(Run, edits.run).stop = state, frames, stop

    known("importing", None, None)
    with pytest.raises(Conflict, match="not known yet"):
        send(edits, "1", relabel(3), {"m1": 0})
    for step, (frames, stop) in enumerate(((None, 4), (4, None), (2, 4), (4, 2))):
        known("importing", frames, stop)
        assert send(edits, f"2{step}", relabel(step), {"m1": step}).docs[0].class_id == step
        with pytest.raises(Invalid, match="0 to 3"):
            send(edits, "3", {**relabel(3), "frame": 4}, {"m1": step + 1})
    known("ready", 3, 4)
    with pytest.raises(Invalid, match="0 to 2"):
        send(edits, "4", relabel(3), {"m1": 4})
