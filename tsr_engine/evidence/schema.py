"""The tables of an evidence store with the meaning of every column. ``docs/evidence.md`` repeats them.

Floating-point columns have no declared type on purpose. A column of REAL affinity stores whole numbers as integers and
loses the sign of ``-0.0``. Without affinity SQLite keeps the eight bytes, and a replay can be compared bit by bit. NaN
has no representation in SQLite and is stored as NULL.
"""

from __future__ import annotations

import sqlite3
from dataclasses import dataclass

SCHEMA_VERSION = 1
"""Raised whenever a table or column changes its name or meaning; not for a column that is added at a table's end."""

DATABASE = "evidence.sqlite"
RUN_FILE = "run.json"
LOCK_FILE = "run.lock"


@dataclass(frozen=True, slots=True)
class Table:
    """One table: its columns as ``(name, declaration, meaning)``, its key and further indices."""

    name: str
    meaning: str
    columns: tuple[tuple[str, str, str], ...]
    key: tuple[str, ...]
    indices: tuple[str, ...] = ()

    def statements(self) -> list[str]:
        """The SQL that makes the table and its indices."""
        body = ", ".join(f"{name} {declared}".strip() for name, declared, _ in self.columns)
        clustered = "" if len(self.key) == 1 else " WITHOUT ROWID"
        return [f"CREATE TABLE {self.name} ({body}, PRIMARY KEY ({', '.join(self.key)})){clustered}", *self.indices]

    def insert(self) -> str:
        """The SQL that inserts one row, values in the order of the columns."""
        return f"INSERT INTO {self.name} VALUES ({', '.join('?' * len(self.columns))})"  # noqa: S608


_FRAME = ("frame", "INTEGER NOT NULL", "ordinal of the frame")
_TRACK = ("track_id", "INTEGER NOT NULL", "the track")
_ROW = ("row", "INTEGER NOT NULL", "position within the frame, from 0")


def _box(prefix: str, what: str) -> tuple[tuple[str, str, str], ...]:
    edges = (("x1", "left"), ("y1", "upper"), ("x2", "right"), ("y2", "lower"))
    return tuple((f"{prefix}{name}", "", f"{edge} edge of {what}, px") for name, edge in edges)


TABLES: tuple[Table, ...] = (
    Table(
        "meta",
        "What the store says about itself.",
        (
            ("name", "TEXT NOT NULL", "`schema_version` or `identity`"),
            ("value", "TEXT NOT NULL", "its value; `identity` is the digest that run.json holds too"),
        ),
        ("name",),
    ),
    Table(
        "frames",
        "One row a frame: the frame table confirmed by the decoder, and the frame's own values.",
        (
            ("frame", "INTEGER NOT NULL", "ordinal: 0-based position in presentation order"),
            ("seconds", "", "presentation time, s"),
            ("width", "INTEGER NOT NULL", "width of the upright picture, px"),
            ("height", "INTEGER NOT NULL", "height of the upright picture, px"),
            ("shift_x", "", "global camera shift against the previous frame, px to the right"),
            ("shift_y", "", "global camera shift against the previous frame, px downwards"),
            ("pts", "INTEGER", "presentation time in units of the time base of run.json; NULL if unknown"),
            ("key_frame", "INTEGER NOT NULL", "1: the decoder can start here"),
            ("corrupt", "INTEGER NOT NULL", "1: the decoder flagged the picture as damaged"),
            ("alive", "INTEGER NOT NULL", "number of tracks in this frame that are not dead"),
        ),
        ("frame",),
        ("CREATE INDEX quiet_frames ON frames (frame) WHERE alive = 0",),
    ),
    Table(
        "detections",
        "Offline detections, best first (Eq. 1, 2).",
        (
            _FRAME,
            _ROW,
            *_box("", "the box"),
            ("raw_score", "", "score before the spatial prior"),
            ("prior", "", "P_spatial at the centre of the box, in [0, 1]"),
            ("score", "", "final score: raw + (P - 1/2) * lambda"),
        ),
        ("frame", "row"),
    ),
    Table(
        "track_frames",
        "One row a track and frame: the result.",
        (
            _FRAME,
            _TRACK,
            _ROW,
            ("state", "TEXT NOT NULL", "`tentative`, `confirmed` or `dead`"),
            ("source", "TEXT NOT NULL", "`detected`, `predicted` or `relocalised`"),
            *_box("", "the result"),
            ("score", "", "final score of the associated detection, else the track's decayed one"),
            ("detection", "INTEGER", "row of the associated detection; NULL: none"),
        ),
        ("frame", "track_id"),
        ("CREATE INDEX track_frames_by_track ON track_frames (track_id, frame)",),
    ),
    Table(
        "predictions",
        "The motion model's view before the frame's measurement; no row in the frame of birth.",
        (
            _FRAME,
            _TRACK,
            *_box("", "the predicted box"),
            ("covariance", "BLOB NOT NULL", "16 little-endian float64: 4 x 4 innovation covariance, row by row, px^2"),
        ),
        ("frame", "track_id"),
    ),
    Table(
        "gates",
        "Factors and verdict of the gate (Eq. 3).",
        (
            _FRAME,
            _TRACK,
            ("symmetry_magnitude", "", "strength of the best mirror axis, in [0, 1]"),
            ("symmetry", "", "`symm`: 1 / max(`symmetry_magnitude`, `gate.symmetry_floor`)"),
            ("hash_distance", "", "`p_ph`: Hamming distance of the perceptual hashes, 0..64"),
            ("position_distance", "", "`p_pos`: distance of the centres, in px or sides as `position_unit` says"),
            ("l_positive", "", "the product"),
            ("confident", "INTEGER NOT NULL", "1: the product lies below tau"),
        ),
        ("frame", "track_id"),
    ),
    Table(
        "relocalisations",
        "Answers of the online detector (Algorithm 2).",
        (
            _FRAME,
            _TRACK,
            *_box("search_", "everything that was searched"),
            *_box("", "the window with the highest response"),
            ("decision", "", "SVM decision value of that window"),
            ("probability", "", "P(y = 1) of that window"),
            *_box("runner_up_", "the best window away from the peak"),
            ("runner_up_decision", "", "its SVM decision value"),
            ("windows", "INTEGER NOT NULL", "number of windows that were scored"),
        ),
        ("frame", "track_id"),
    ),
    Table(
        "samples",
        "Samples that the online detector learned or unlearned in this frame, in order.",
        (
            _FRAME,
            _TRACK,
            _ROW,
            ("transform", "TEXT NOT NULL", "`learned` or `unlearned`"),
            ("label", "INTEGER NOT NULL", "+1 or -1"),
            ("origin", "TEXT NOT NULL", "`offline`, `prediction`, `result` or `background`"),
            ("origin_frame", "INTEGER NOT NULL", "frame that the sample was cut from; -1: offline"),
        ),
        ("frame", "track_id", "row"),
    ),
    Table(
        "recognitions",
        "Class probabilities of the crop and the votes fused so far (Eq. 4, 5).",
        (
            _FRAME,
            _TRACK,
            ("probabilities", "BLOB NOT NULL", "little-endian float32, one a class: P(c | x_t)"),
            ("scale", "", "s_t: side of the crop, px"),
            ("weight", "", "w_t"),
            ("votes", "BLOB NOT NULL", "little-endian float64, one a class: votes up to this frame"),
            ("class_id", "INTEGER NOT NULL", "class with the most votes"),
            ("share", "", "its share of all votes, in [0, 1]"),
            ("runner_up", "INTEGER NOT NULL", "class with the second most votes"),
        ),
        ("frame", "track_id"),
    ),
    Table(
        "events",
        "What happened to tracks, in order.",
        (
            _FRAME,
            _ROW,
            _TRACK,
            ("kind", "TEXT NOT NULL", "`born`, `confirmed`, `rejected`, `relocalised`, `missed`, `died`, `relabelled`"),
            ("text", "TEXT NOT NULL", "one sentence; other versions may word it otherwise: replays leave it aside"),
            ("facts", "TEXT NOT NULL", "JSON object: the values behind the sentence"),
        ),
        ("frame", "row"),
        ("CREATE INDEX events_by_track ON events (track_id, frame)",),
    ),
    Table(
        "regions",
        "Rectangles of the frame's own pixels, bit-exact.",
        (
            _FRAME,
            _ROW,
            ("x", "INTEGER NOT NULL", "left column in the frame"),
            ("y", "INTEGER NOT NULL", "upper row in the frame"),
            ("width", "INTEGER NOT NULL", "columns"),
            ("height", "INTEGER NOT NULL", "rows"),
            ("pixels", "BLOB NOT NULL", "BGR, differenced and deflated as described under Pixels"),
        ),
        ("frame", "row"),
    ),
    Table(
        "timings",
        "Seconds of every stage.",
        (
            _FRAME,
            _ROW,
            ("stage", "TEXT NOT NULL", "name of the stage"),
            ("seconds", "", "time spent in this frame, s"),
        ),
        ("frame", "row"),
    ),
    Table(
        "tracks",
        "One row a track, brought up to date with every chunk.",
        (
            ("track_id", "INTEGER NOT NULL", "the track"),
            ("first_frame", "INTEGER NOT NULL", "frame of birth"),
            ("last_frame", "INTEGER NOT NULL", "last frame in which it is not dead"),
            ("frames", "INTEGER NOT NULL", "number of frames in which it is not dead"),
            ("detected_frames", "INTEGER NOT NULL", "number of those with an associated detection"),
            ("confirmed_frame", "INTEGER", "frame of confirmation; NULL: never confirmed"),
            ("best_score", "", "highest score"),
            ("largest_side", "", "longest side of any of its boxes, px"),
            ("class_id", "INTEGER", "fused class of the whole track; NULL: never recognised"),
            ("share", "", "its share of all votes; NULL: never recognised"),
        ),
        ("track_id",),
        ("CREATE INDEX tracks_by_span ON tracks (first_frame, last_frame)",),
    ),
)

BY_NAME = {table.name: table for table in TABLES}


def create_tables(connection: sqlite3.Connection) -> None:
    """Make all tables in an empty database, in one transaction of the caller."""
    for table in TABLES:
        for statement in table.statements():
            connection.execute(statement)
