"""Add sums over documents and log, so that pages about a whole library need not read them."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import sqlalchemy as sa
from alembic import op

from app.storage.utc_times import UtcDateTime
from tsr_engine.json_shapes import JsonObject

revision = "0013"
down_revision = "0012"

_COUNTS = ("tracks", "accepted", "rejected", "notes")
_DECIDED = ("accepted", "rejected")
_JUDGING = ("set_review", "review_tracks")
_BREAK = timedelta(minutes=5)
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC).date()
_AT_ONCE = 1000
_STREAMED = {"yield_per": _AT_ONCE}

_text, _number = sa.Text(), sa.Integer()
_EDITS = sa.table(
    "edits",
    *(sa.column(name, _text) for name in ("op_id", "run_id", "author", "kind", "reverts")),
    *(sa.column(name, sa.JSON()) for name in ("command", "after")),
    sa.column("seq", sa.BigInteger()),
    sa.column("created", UtcDateTime()),
)
_DOCUMENTS = sa.table(
    "track_documents", sa.column("run_id", _text), sa.column("key", _text), sa.column("document", sa.JSON())
)
_TRACKS = sa.table("search_tracks", *(sa.column(name, _text) for name in ("run_id", "state", "notes")))
_RUNS = sa.table("search_runs", sa.column("run_id", _text), *(sa.column(name, _number) for name in _COUNTS))
_REVIEW_COUNTS = sa.table(
    "review_counts", sa.column("run_id", _text), sa.column("more", _number), sa.column("reviewed", _number)
)
_VERDICTS = sa.table(
    "verdicts",
    *(sa.column(name, _text) for name in ("run_id", "key", "author", "verdict")),
    sa.column("day", _number),
)
_WORK = sa.table(
    "work_days",
    sa.column("author", _text),
    sa.column("day", _number),
    sa.column("seq", sa.BigInteger()),
    *(sa.column(name, sa.Float()) for name in ("seconds", "back")),
    *(sa.column(name, UtcDateTime()) for name in ("last", "latest")),
)


def upgrade() -> None:
    """Add the tables, and compute the sums of existing data."""
    for name in _COUNTS:
        op.add_column("search_runs", sa.Column(name, sa.Integer(), nullable=False, server_default="0"))
    op.create_table(
        "review_counts",
        sa.Column("run_id", sa.String(length=32), sa.ForeignKey("runs.id", ondelete="CASCADE"), nullable=False),
        sa.Column("more", sa.Integer(), nullable=False),
        sa.Column("reviewed", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("run_id"),
    )
    op.create_table(
        "verdicts",
        sa.Column("run_id", sa.String(length=32), sa.ForeignKey("runs.id", ondelete="CASCADE"), nullable=False),
        sa.Column("key", sa.String(length=64), nullable=False),
        sa.Column("author", sa.Text(), nullable=False),
        sa.Column("verdict", sa.String(length=16), nullable=False),
        sa.Column("day", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("run_id", "key", "author"),
    )
    op.create_index("verdicts_by_day", "verdicts", ["day", "author", "verdict"])
    op.create_table(
        "work_days",
        sa.Column("author", sa.Text(), nullable=False),
        sa.Column("day", sa.Integer(), nullable=False),
        sa.Column("seconds", sa.Float(), nullable=False),
        sa.Column("seq", sa.BigInteger(), nullable=False),
        sa.Column("last", sa.DateTime(timezone=True), nullable=False),
        sa.Column("latest", sa.DateTime(timezone=True), nullable=False),
        sa.Column("back", sa.Float(), nullable=False),
        sa.PrimaryKeyConstraint("author", "day"),
    )
    op.create_index("work_days_by_seq", "work_days", ["author", "seq"])
    op.create_index("work_days_by_latest", "work_days", ["latest"])
    fill(op.get_bind())


def downgrade() -> None:
    """Back."""
    for table in ("work_days", "verdicts", "review_counts"):
        op.drop_table(table)
    with op.batch_alter_table("search_runs") as batch:
        for name in _COUNTS:
            batch.drop_column(name)


def fill(connection: sa.Connection) -> None:
    """Compute all sums from documents and log."""
    for table in (_REVIEW_COUNTS, _VERDICTS, _WORK):
        connection.execute(sa.delete(table))
    _fill_review_counts(connection)
    _fill_search_runs(connection)
    _fill_verdicts(connection)
    _fill_work_days(connection)


def _fill_review_counts(connection: sa.Connection) -> None:
    row = _DOCUMENTS.c
    gone = sa.func.coalesce(row.document["gone"].as_boolean(), sa.false())
    own = sa.not_(row.key.startswith("m"))
    more = sa.case((sa.and_(own, sa.not_(gone)), 1), (sa.and_(sa.not_(own), gone), -1), else_=0)
    reviewed = sa.case((sa.and_(row.document["review"].as_string().in_(_DECIDED), sa.not_(gone)), 1), else_=0)
    counts = sa.select(row.run_id, sa.func.sum(more), sa.func.sum(reviewed)).group_by(row.run_id)
    connection.execute(sa.insert(_REVIEW_COUNTS).from_select(["run_id", "more", "reviewed"], counts))


def _fill_search_runs(connection: sa.Connection) -> None:
    row = _TRACKS.c
    lines = sa.func.length(row.notes) - sa.func.length(sa.func.replace(row.notes, "\n", "")) + 1
    columns = (
        sa.func.sum(sa.case((row.state != "ignored", 1), else_=0)),
        *(sa.func.sum(sa.case((row.state == state, 1), else_=0)) for state in _DECIDED),
        sa.func.sum(sa.case((row.notes != "", lines), else_=0)),
    )
    found = connection.execute(sa.select(row.run_id, *columns).group_by(row.run_id)).all()
    update = sa.update(_RUNS).where(_RUNS.c.run_id == sa.bindparam("run"))
    update = update.values({name: sa.bindparam(f"new_{name}") for name in _COUNTS})
    rows = [
        {"run": run} | {f"new_{name}": n for name, n in zip(_COUNTS, counts, strict=True)} for run, *counts in found
    ]
    _all_at_once(connection, update, rows)


def _fill_verdicts(connection: sa.Connection) -> None:
    row = _EDITS.c
    reverting = sa.select(row.reverts, row.kind).where(row.kind.in_(("undo", "redo"))).order_by(row.seq)
    stands = dict(connection.execute(reverting).all())
    judging = sa.select(row.op_id, row.run_id, row.author, row.kind, row.command, row.created, row.after)
    judging = judging.where(row.kind.in_((*_JUDGING, "edit_tracks"))).order_by(row.seq)
    found: dict[tuple[str, str, str], tuple[str, int]] = {}
    for edit in connection.execute(judging, execution_options=_STREAMED):
        commands = edit.command["commands"] if edit.kind == "edit_tracks" else [edit.command]
        verdict = next((each["review"] for each in commands if each["name"] in _JUDGING), None)
        if verdict in _DECIDED and stands.get(edit.op_id) != "undo":
            for key in edit.after:
                found[edit.run_id, key, edit.author] = verdict, _day(edit.created)
    names = ("run_id", "key", "author", "verdict", "day")
    rows = [dict(zip(names, (*whose, *what), strict=True)) for whose, what in found.items()]
    _all_at_once(connection, sa.insert(_VERDICTS), rows)


def _fill_work_days(connection: sa.Connection) -> None:
    row = _EDITS.c
    query = sa.select(row.seq, row.author, row.created).order_by(row.seq)
    days: dict[tuple[str, int], JsonObject] = {}
    before: dict[str, datetime] = {}
    furthest: datetime | None = None
    for seq, author, created in connection.execute(query, execution_options=_STREAMED):
        own = {"author": author, "day": _day(created)}
        day = days.setdefault((author, own["day"]), own | {"seconds": 0.0, "back": 0.0, "latest": created})
        pause = min(max(created - before.get(author, created), timedelta()), _BREAK)
        back = timedelta() if furthest is None else max(timedelta(), furthest - created)
        day["seconds"] += pause.total_seconds()
        day["back"] = max(day["back"], back.total_seconds())
        day["latest"] = max(day["latest"], created)
        day["seq"], day["last"] = seq, created
        before[author] = created
        furthest = created if furthest is None else max(furthest, created)
    _all_at_once(connection, sa.insert(_WORK), list(days.values()))


def _day(moment: datetime) -> int:
    return (moment.astimezone(UTC).date() - _EPOCH).days


def _all_at_once(connection: sa.Connection, statement: sa.Executable, rows: list[JsonObject]) -> None:
    for start in range(0, len(rows), _AT_ONCE):
        connection.execute(statement, rows[start : start + _AT_ONCE])
