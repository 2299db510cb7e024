"""Number runs in the order in which they are made, because the clock may be wrong or set back."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Number existing runs by the clock, which is the only information about them.

    The column gets a permanent default: SQLite could only drop that by making the table again, and dropping the old
    table would delete the edits.
    """
    op.add_column("runs", sa.Column("order", sa.BigInteger(), nullable=False, server_default="0"))
    runs = sa.table("runs", sa.column("id"), sa.column("created"), sa.column("order"))
    connection = op.get_bind()
    known = connection.scalars(sa.select(runs.c.id).order_by(runs.c.created, runs.c.id)).all()
    for number, run in enumerate(known, 1):
        connection.execute(sa.update(runs).where(runs.c.id == run).values({"order": number}))
    op.create_index(op.f("ix_runs_order"), "runs", ["order"], unique=False)


def downgrade() -> None:
    """Back."""
    op.drop_index(op.f("ix_runs_order"), "runs")
    op.drop_column("runs", "order")
