"""Add the shape of pixels, so that videos whose pixels are not square are shown undistorted."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    """Add the column; existing videos keep square pixels until they are added again."""
    op.add_column("videos", sa.Column("pixel_ratio", sa.Float(), nullable=False, server_default="1"))


def downgrade() -> None:
    """Back."""
    op.drop_column("videos", "pixel_ratio")
