"""Videos: by content, never by name; their frames, by ordinal."""
