"""Keys of the classes in the header of a run."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from tests.evidence.synthetic_evidence import make_header
from tsr_engine.evidence.header import read_header, write_header


def test_a_run_of_the_usual_classes_is_stored_as_before(tmp_path: Path) -> None:
    header = make_header()
    write_header(tmp_path, header)
    content = json.loads((tmp_path / "run.json").read_text())
    assert "labels" not in content
    known = {
        "video": [header.video.sha256, header.video.size],
        "parameters": header.parameters,
        "models": dict(header.models),
        "engine": header.engine_version,
        "schema": header.schema_version,
        "pixels": True,
    }
    assert header.identity() == hashlib.sha256(json.dumps(known, sort_keys=True).encode()).hexdigest()
    assert read_header(tmp_path).labels is None


def test_other_classes_are_another_run(tmp_path: Path) -> None:
    header = make_header(labels=("stop", "bus-stop"))
    assert header.identity() != make_header().identity()
    assert header.differences(make_header()) == ["labels: the classes of the two are not the same signs"]
    write_header(tmp_path, header)
    assert read_header(tmp_path).labels == ("stop", "bus-stop")
