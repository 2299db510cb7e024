"""Alembic's scripts: each changes the tables of one version to those of the next."""
