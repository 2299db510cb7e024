"""Stores reports of videos by a digest of engine, parameters, models and files.

A change of any of these gives another digest, so that no outdated report is used. With the store, stopped experiments
can continue, and several experiments share reports.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

from benchmarks.cache import ENGINE, code, file_digest, table_digest
from tsr_engine.evaluation.tracking import SignReport, VideoReport
from tsr_engine.io.atomic import atomic_text
from tsr_engine.json_shapes import JsonMapping
from tsr_engine.params import Params
from tsr_engine.track_table import TrackTable


class ResultCache:
    """Records in a folder.

    Args:
        folder: folder of the records, made on first use; None: nothing is stored.
    """

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder

    def find(self, key: str) -> tuple[VideoReport, dict[str, float]] | None:
        """The report and the times by stage that are stored under a key."""
        path = self._path(key)
        if path is None or not path.is_file():
            return None
        record = json.loads(path.read_text(encoding="utf-8"))
        return _report(record["report"]), {str(k): float(v) for k, v in record["stages"].items()}

    def keep(self, key: str, report: VideoReport, stages: Mapping[str, float]) -> None:
        """Store the report of one video."""
        path = self._path(key)
        if path is not None:
            with atomic_text(path) as out:
                json.dump({"report": asdict(report), "stages": dict(stages)}, out)

    def _path(self, key: str) -> Path | None:
        return None if self._folder is None else self._folder / f"{key}.json"

    @staticmethod
    def key(title: str, video: Path, truth: TrackTable, params: Params, models: Mapping[str, str]) -> str:
        """Digest of everything that a report depends on."""
        parts = [code(ENGINE), file_digest(video), table_digest(truth), title, params.model_dump_json(), dict(models)]
        return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def _report(record: JsonMapping) -> VideoReport:
    signs = tuple(SignReport(**(sign | {"ids": tuple(sign["ids"])})) for sign in record["signs"])
    lists = {
        "signs": signs,
        "errors": tuple((float(error), str(source)) for error, source in record["errors"]),
        "followed_errors": tuple(record["followed_errors"]),
        "narrow_errors": tuple(record["narrow_errors"]),
        "false_tracks": tuple(record["false_tracks"]),
        "matched": tuple((int(frame), int(sign)) for frame, sign in record["matched"]),
    }
    return VideoReport(**(dict(record) | lists))
