"""Recordings for the Rerun viewer, made from stored evidence.

::

    report = write_recording(RecordingRequest(Path("runs/drive"), Path("drive.rrd"), 100, 400, Path("drive.mp4")))
"""

from tsr_engine.recording.content import BoxRows
from tsr_engine.recording.layers import LAYERS
from tsr_engine.recording.request import RecordingReport, RecordingRequest
from tsr_engine.recording.write import write_recording

__all__ = ["LAYERS", "BoxRows", "RecordingReport", "RecordingRequest", "write_recording"]
