"""Add the state of a video's file when its bytes were last compared, and the server that has the files of a row."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"

_PLACED = ("videos", "runs", "artefacts", "model_versions", "jobs")


def upgrade() -> None:
    """Add the columns; when a server starts, it becomes the owner of files in its data folder."""
    op.create_table(
        "servers",
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("name", sa.Text(), nullable=False),
        sa.Column("beats", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("id"),
    )
    for table in _PLACED:
        op.add_column(table, sa.Column("place", sa.String(length=32), nullable=True))
    op.add_column("videos", sa.Column("stamp", sa.JSON(), nullable=True))


def downgrade() -> None:
    """Back."""
    op.drop_column("videos", "stamp")
    for table in _PLACED:
        op.drop_column(table, "place")
    op.drop_table("servers")
