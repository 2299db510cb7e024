"""What the tool remembers: tables, sessions, migrations."""
