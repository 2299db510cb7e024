"""Tracks and lanes against a simple count over the engine's records."""

from __future__ import annotations

import json
import sqlite3
from collections import Counter
from contextlib import closing
from itertools import groupby
from pathlib import Path
from typing import Any

import pytest

from app.evidence.service import EvidenceService
from app.evidence.tracks import read_track_properties
from app.settings import Settings
from app.storage.database import Database
from tests.app import long_run, toy_home
from tsr_engine.errors import TsrError
from tsr_engine.evidence.schema import DATABASE

CODES = {"detected": 0, "predicted": 1, "relocalised": 2}


def live_tracks(home: Any) -> dict[int, list[tuple[int, Any]]]:
    with home.reader() as reader:
        confirmed = [track.track_id for track in reader.tracks() if track.confirmed]
        return {i: [(k, t) for k, t in reader.track(i) if t.state != "dead"] for i in confirmed}


def clearest(frames: list[tuple[int, Any]], home: Any) -> int:
    """The largest sharp view inside the picture, if there is one."""
    with home.reader() as reader:
        sizes = {k: (width, height) for k, width, height in reader.query("SELECT frame, width, height FROM frames")}
    best = max(t.score for _, t in frames)

    def rank(seen: tuple[int, Any]) -> tuple[bool, bool, float]:
        x1, y1, x2, y2 = seen[1].box.tolist()
        width, height = sizes[seen[0]]
        inside = min(x1, width - x2) > 0.05 * (x2 - x1) and min(y1, height - y2) > 0.05 * (y2 - y1)
        return inside, seen[1].score >= min(best / 2, best - 3), (x2 - x1) * (y2 - y1)

    return max(((k, t) for k, t in frames if t.detection is not None), key=rank)[0]


def test_track_columns_equal_the_records(home: Any) -> None:
    columns = json.loads(home.evidence.tracks(home.run_id))
    with home.reader() as reader:
        facts = read_track_properties(reader)
    records = live_tracks(home)
    assert columns["id"] == sorted(records)
    assert len(records) >= 2
    assert columns["complete"] is True
    assert columns["tau"] == 3.0
    for index, track in enumerate(columns["id"]):
        frames = records[track]
        sources = Counter(t.source for _, t in frames)
        assert columns["first"][index] == frames[0][0]
        assert columns["last"][index] == frames[-1][0]
        assert columns["frames"][index] == len(frames)
        assert columns["detected"][index] == sum(t.detection is not None for _, t in frames)
        assert columns["clearest"][index] == clearest(frames, home)
        assert columns["relocalised"][index] == sources["relocalised"]
        last = [t.recognition for _, t in frames if t.recognition is not None][-1]
        assert columns["class_id"][index] == last.class_id
        assert columns["share"][index] == pytest.approx(last.share, abs=1e-4)
        assert columns["runner_up"][index] == last.runner_up
        expected = last.votes[last.runner_up] / last.votes.sum()
        assert columns["runner_up_share"][index] == pytest.approx(expected, abs=1e-4)
        assert 0 <= columns["uncertainty"][index] <= 1
        rejected = sum(t.gate is not None and not t.gate.confident for _, t in frames)
        assert columns["rejected"][index] == rejected
        # as many verdicts as in the lanes: without the frame in which the track ended
        assert facts.judged[index] == sum(t.gate is not None for _, t in frames)
    assert sum(columns["rejected"]) > 0


def test_lanes_are_runs_of_equal_source(home: Any) -> None:
    lanes = json.loads(home.evidence.lanes(home.run_id))
    expected = []
    for track, frames in sorted(live_tracks(home).items()):
        numbered = enumerate((k, CODES[t.source]) for k, t in frames)
        for (_, source), group in groupby(numbered, key=lambda pair: (pair[1][0] - pair[0], pair[1][1])):
            run = [k for _, (k, _) in group]
            expected.append((track, run[0], run[-1], source))
    assert list(zip(*(lanes[name] for name in ("track", "first", "last", "source")), strict=True)) == expected
    assert len({source for *_, source in expected}) >= 2


def test_gaps_lie_between_the_boxes_of_a_track_and_after_its_end(tmp_path: Path) -> None:
    made = long_run.make_long_run(tmp_path, frames=200, tracks=6)
    settings = Settings(home=tmp_path)
    evidence = EvidenceService(settings, Database(settings.database))
    spans = evidence.all_spans(made.run_id)
    ended = next(track for track, (_, last) in spans.items() if last < 199)
    first, last = spans[ended]
    newest = max(spans, key=lambda track: spans[track][1])
    with closing(sqlite3.connect(tmp_path / "runs" / made.run_id / DATABASE)) as store, store:
        missing = first + 1, first + 3, first + 4
        store.execute(f"DELETE FROM track_frames WHERE track_id = {ended} AND frame IN {missing}")
        store.execute(f"DELETE FROM frames WHERE frame > {spans[newest][1]}")
    assert evidence.gaps(made.run_id, ended) == [(first + 1, first + 1), (first + 3, first + 4), (last + 1, None)]
    assert evidence.gaps(made.run_id, newest) == [], "it goes on"
    assert evidence.gaps(made.run_id, 999) == []
    evidence.close()


def test_a_run_without_stored_frames_has_no_tracks(home: Any) -> None:
    run = home.add_run(state="queued", folder="runs/nothing")
    assert json.loads(home.evidence.tracks(run)) == {
        **{name: [] for name in json.loads(home.evidence.tracks(home.run_id)) if name not in ("tau", "complete")},
        "tau": 3.0,
        "complete": False,
    }
    assert json.loads(home.evidence.lanes(run))["track"] == []
    assert home.evidence.overlays(run, 0, 5) == []


def test_a_growing_run_shows_each_new_chunk(tmp_path: Any) -> None:
    from tsr_engine.evidence import EvidenceWriter

    home = toy_home.make_home(tmp_path)
    growing = home.add_run(state="running")
    try:
        with home.reader() as reader:
            frames, header = list(reader.frames()), reader.header
        with EvidenceWriter.create(home.settings.home / "runs" / growing, header) as writer:
            seen = []
            for frame in frames:
                writer.append(frame)
                if frame.ordinal in (31, 63):
                    columns = json.loads(home.evidence.tracks(growing))
                    seen.append((columns["complete"], sum(columns["frames"])))
        with home.database.write() as session:
            session.get(toy_home.Run, growing).state = "complete"
        columns = json.loads(home.evidence.tracks(growing))
        seen.append((columns["complete"], sum(columns["frames"])))
        assert [done for done, _ in seen] == [False, False, True]
        assert seen[0][1] < seen[1][1] <= seen[2][1]
        assert sum(columns["frames"]) == sum(json.loads(home.evidence.tracks(home.run_id))["frames"])
    finally:
        home.evidence.close()
        home.database.close()


def test_a_damaged_store_is_reported_in_one_sentence(tmp_path: Any) -> None:
    home = toy_home.make_home(tmp_path, 20)
    (home.folder / "run.json").write_text("{")
    with pytest.raises(TsrError, match="damaged"):
        home.evidence.tracks(home.run_id)
    home.evidence.close()
    home.database.close()
