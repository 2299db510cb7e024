"""The search across videos, and tags of videos."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"

_INDEXES = {
    "search_by_uncertainty": ["current", "uncertainty", "run_id", "key"],
    "search_by_label": ["set_key", "label", "current", "uncertainty"],
    "search_by_state": ["current", "state", "uncertainty"],
    "search_by_size": ["current", "size", "run_id", "key"],
    "search_by_edit": ["current", "edited", "run_id", "key"],
}


def upgrade() -> None:
    """Add the tables; the server fills those of the search by itself."""
    op.create_table(
        "video_tags",
        sa.Column("video_id", sa.String(length=64), nullable=False),
        sa.Column("tag", sa.String(length=60), nullable=False),
        sa.ForeignKeyConstraint(["video_id"], ["videos.id"], ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("video_id", "tag"),
    )
    op.create_index(op.f("ix_video_tags_tag"), "video_tags", ["tag"], unique=False)
    op.create_table(
        "search_runs",
        sa.Column("run_id", sa.String(length=32), nullable=False),
        sa.Column("video_id", sa.String(length=64), nullable=False),
        sa.Column("basis", sa.String(length=64), nullable=False),
        sa.Column("set_key", sa.String(length=64), nullable=False),
        sa.Column("seq", sa.BigInteger(), nullable=False),
        sa.Column("current", sa.Boolean(), nullable=False),
        sa.Column("error", sa.Text(), nullable=True),
        sa.ForeignKeyConstraint(["run_id"], ["runs.id"], ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("run_id"),
    )
    op.create_index(op.f("ix_search_runs_video_id"), "search_runs", ["video_id"], unique=False)
    op.create_table(
        "search_tracks",
        sa.Column("run_id", sa.String(length=32), nullable=False),
        sa.Column("key", sa.String(length=64), nullable=False),
        sa.Column("video_id", sa.String(length=64), nullable=False),
        sa.Column("current", sa.Boolean(), nullable=False),
        sa.Column("set_key", sa.String(length=64), nullable=False),
        sa.Column("label", sa.Integer(), nullable=False),
        sa.Column("state", sa.String(length=16), nullable=False),
        *(sa.Column(name, sa.Float(), nullable=False) for name in ("uncertainty", "engine_uncertainty", "size")),
        sa.Column("frame", sa.Integer(), nullable=False),
        *(sa.Column(name, sa.Float(), nullable=False) for name in ("x1", "y1", "x2", "y2")),
        *(sa.Column(name, sa.Integer(), nullable=False) for name in ("first", "last", "revision")),
        sa.Column("author", sa.Text(), nullable=True),
        sa.Column("edited", sa.BigInteger(), nullable=False),
        sa.Column("notes", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["run_id"], ["runs.id"], ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("run_id", "key"),
    )
    op.create_index(op.f("ix_search_tracks_video_id"), "search_tracks", ["video_id"], unique=False)
    for name, columns in _INDEXES.items():
        op.create_index(name, "search_tracks", columns, unique=False)
    op.create_table(
        "search_attributes",
        sa.Column("run_id", sa.String(length=32), nullable=False),
        sa.Column("key", sa.String(length=64), nullable=False),
        sa.Column("name", sa.String(length=200), nullable=False),
        sa.Column("value", sa.String(length=200), nullable=False),
        sa.ForeignKeyConstraint(["run_id"], ["runs.id"], ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("run_id", "key", "name", "value"),
    )
    op.create_index("search_by_attribute", "search_attributes", ["name", "value"], unique=False)


def downgrade() -> None:
    """Back."""
    for table in ("search_attributes", "search_tracks", "search_runs", "video_tags"):
        op.drop_table(table)
