"""Give ids of assignments and second opinions only once: SQLite gave those of removed rows again."""

from __future__ import annotations

from alembic import op

revision = "0015"
down_revision = "0014"


def upgrade() -> None:
    """Copy the tables with AUTOINCREMENT; no other table refers to them. PostgreSQL gives each id once anyway."""
    if op.get_bind().dialect.name == "sqlite":
        for table in ("assignments", "second_opinions"):
            with op.batch_alter_table(table, recreate="always", table_kwargs={"sqlite_autoincrement": True}):
                pass


def downgrade() -> None:
    """Back: earlier versions use the tables as they are."""
