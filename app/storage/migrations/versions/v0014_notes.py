"""Add the note of a running job to what it works on."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"

_TABLES = ("runs", "follows", "model_versions")


def upgrade() -> None:
    """Add the columns, empty."""
    for table in _TABLES:
        op.add_column(table, sa.Column("note", sa.Text(), nullable=False, server_default=""))


def downgrade() -> None:
    """Back."""
    for table in _TABLES:
        op.drop_column(table, "note")  # in place: a copied table would take its edits along when the old one is dropped
