"""Persistent data: tables, sessions, migrations."""
