"""Keep one index of tracks: drop the second copy of the engine's labels, add two indexes. Add second opinions."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"


def upgrade() -> None:
    """Forward."""
    op.drop_table("track_classes")
    op.create_index("search_by_state_and_size", "search_tracks", ["current", "state", "size"], unique=False)
    only = sa.text("notes != ''")
    op.create_index(
        "search_by_notes",
        "search_tracks",
        ["current", "run_id", "key"],
        unique=False,
        sqlite_where=only,
        postgresql_where=only,
    )
    op.create_table(
        "second_opinions",
        sa.Column("id", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), autoincrement=True, nullable=False),
        sa.Column("run_id", sa.String(length=32), sa.ForeignKey("runs.id", ondelete="CASCADE"), nullable=False),
        sa.Column("key", sa.String(length=64), nullable=False),
        sa.Column("set_key", sa.String(length=64), nullable=False),
        sa.Column("first", sa.Text(), nullable=False),
        sa.Column("first_label", sa.Integer(), nullable=False),
        sa.Column("revision", sa.Integer(), nullable=False),
        sa.Column("person_id", sa.String(length=32), sa.ForeignKey("people.id", ondelete="SET NULL"), nullable=True),
        sa.Column("second", sa.Text(), nullable=False),
        sa.Column("second_label", sa.Integer(), nullable=True),
        sa.Column("answered", sa.DateTime(timezone=True), nullable=True),
        sa.PrimaryKeyConstraint("id"),
        sa.UniqueConstraint("run_id", "key", name="second_opinion_of_track"),
    )
    op.create_index("ix_second_opinions_person_id", "second_opinions", ["person_id"])


def downgrade() -> None:
    """Back."""
    op.drop_table("second_opinions")
    op.drop_index("search_by_notes", table_name="search_tracks")
    op.drop_index("search_by_state_and_size", table_name="search_tracks")
    op.create_table(
        "track_classes",
        sa.Column("run_id", sa.String(length=32), sa.ForeignKey("runs.id", ondelete="CASCADE"), nullable=False),
        sa.Column("rows", sa.LargeBinary(), nullable=False),
        sa.PrimaryKeyConstraint("run_id"),
    )
