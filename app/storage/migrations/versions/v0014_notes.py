"""Add the note of a job to what it works on; runs that wait for another server get theirs."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"

_WAITING = """
UPDATE runs SET note = 'the server ' || (SELECT name FROM servers WHERE servers.id = runs.place) || ' has the video'
WHERE state = 'queued' AND place IN (SELECT id FROM servers WHERE beats != 0)
AND (SELECT count(*) FROM servers WHERE beats != 0) > 1
"""
"""The note of runs that wait, if there are several servers; shared files have no beats."""
_TABLES = ("runs", "follows", "model_versions")


def upgrade() -> None:
    """Add the columns."""
    for table in _TABLES:
        op.add_column(table, sa.Column("note", sa.Text(), nullable=False, server_default=""))
    op.execute(_WAITING)


def downgrade() -> None:
    """Back."""
    for table in _TABLES:
        op.drop_column(table, "note")  # in place: a copied table would take its edits along when the old one is dropped
