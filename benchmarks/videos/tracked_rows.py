"""Result rows of the whole engine on a video, as ``tsr track --csv`` writes them."""

from __future__ import annotations

import tempfile
from pathlib import Path

from tsr_engine.evaluation.track_tables import read_results
from tsr_engine.params import Params
from tsr_engine.pipeline import Components
from tsr_engine.runs.report import RunReport
from tsr_engine.runs.track_video import RunRequest, track_video
from tsr_engine.track_table import TrackTable


def track_rows(video: Path, params: Params, components: Components) -> tuple[RunReport, TrackTable]:
    """Run the engine on a video; returns its report and its result rows."""
    with tempfile.TemporaryDirectory() as folder:
        rows = Path(folder) / "rows.csv"
        report = track_video(RunRequest(video, params, csv=rows), components)
        return report, read_results(rows)
