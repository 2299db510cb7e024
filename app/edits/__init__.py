"""People's corrections: documents, commands, the append-only log, undo."""
