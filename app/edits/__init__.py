"""What people change: documents, commands, the append-only log, undo."""
