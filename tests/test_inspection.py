"""A verdict of the gate is recomputed to the stored value, with its inputs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests import toy_pipeline
from tsr_engine.errors import EvidenceError
from tsr_engine.evidence import EvidenceReader
from tsr_engine.evidence.regions import StoredPixels
from tsr_engine.pipeline.gate_inspection import Inspection, inspect_gate
from tsr_engine.runs.track_video import RunRequest, track_video


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("inspection")
    video = toy_pipeline.write_drive(folder / "drive.mp4", 75)
    track_video(RunRequest(video, toy_pipeline.PARAMS, folder / "run"), toy_pipeline.components())
    return folder / "run"


def inspect(reader: EvidenceReader, track: int, frame: int) -> Inspection | None:
    def pixels(ordinal: int) -> StoredPixels:
        return StoredPixels(toy_pipeline.WIDTH, toy_pipeline.HEIGHT, reader.regions(ordinal))

    return inspect_gate(reader, toy_pipeline.PARAMS, track, frame, pixels)


def test_every_stored_verdict_is_reproduced_bit_by_bit(run: Path) -> None:
    compared = 0
    with EvidenceReader(run) as reader:
        for frame in reader.frames(pixels=False):
            for track in frame.tracks:
                found = inspect(reader, track.track_id, frame.ordinal)
                if track.gate is None:
                    assert found is None
                    continue
                assert found is not None
                assert found.verdict == track.gate
                assert found.symmetry.magnitude == track.gate.symmetry_magnitude
                assert (found.crop_hash ^ found.mean_hash).bit_count() == track.gate.hash_distance
                compared += 1
    assert compared > 40


def test_each_pair_has_one_symmetry_weight(run: Path) -> None:
    seen = 0
    with EvidenceReader(run) as reader:
        for frame in reader.frames(pixels=False):
            for track in frame.tracks:
                found = inspect(reader, track.track_id, frame.ordinal)
                if found is None:
                    continue
                weights, symmetry = found.symmetry.weights, found.symmetry
                assert weights.shape == (len(symmetry.pairs),)
                assert ((weights > 0) & (weights <= 1)).all()
                if symmetry.features:
                    assert symmetry.magnitude == pytest.approx(np.sqrt(min(1.0, weights.sum() / symmetry.features)))
                seen += len(weights)
    assert seen > 50


def test_an_unknown_frame_is_refused(run: Path) -> None:
    with EvidenceReader(run) as reader, pytest.raises(EvidenceError, match="no frame 99"):
        inspect(reader, 1, 99)


def test_any_query_is_allowed_but_no_change(run: Path) -> None:
    with EvidenceReader(run) as reader:
        assert reader.query("SELECT count(*) FROM frames WHERE frame >= ?", (5,)) == [(70,)]
        with pytest.raises(EvidenceError, match="readonly"):
            reader.query("DELETE FROM frames")
        frame = next(f for f in reader.frames() if f.regions)
        kept = reader.regions(frame.ordinal)
        assert [(r.x, r.y) for r in kept] == [(r.x, r.y) for r in frame.regions]
        assert all(np.array_equal(a.pixels, b.pixels) for a, b in zip(kept, frame.regions, strict=True))
