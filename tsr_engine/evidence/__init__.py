"""The evidence of a run: schema, writer, reader, and the pixels kept for replay.

Each run is a folder with ``run.json`` (video, parameters, models) and ``evidence.sqlite`` (decisions, frame by frame).
"""

from tsr_engine.evidence.compare import differences
from tsr_engine.evidence.encode import StoredTrack, TableEntry
from tsr_engine.evidence.header import RunHeader, RunState, VideoIdentity, read_header
from tsr_engine.evidence.reader import RESULT_HEADER, EvidenceReader, ResultRow
from tsr_engine.evidence.regions import FramePixels, StoredPixels
from tsr_engine.evidence.schema import SCHEMA_VERSION
from tsr_engine.evidence.writer import DEFAULT_CHUNK, EvidenceWriter, refuse_run_files

__all__ = [
    "DEFAULT_CHUNK",
    "RESULT_HEADER",
    "SCHEMA_VERSION",
    "EvidenceReader",
    "EvidenceWriter",
    "FramePixels",
    "ResultRow",
    "RunHeader",
    "RunState",
    "StoredPixels",
    "StoredTrack",
    "TableEntry",
    "VideoIdentity",
    "differences",
    "read_header",
    "refuse_run_files",
]
