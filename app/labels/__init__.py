"""The label sets of a library: versions in the database, changes, pictures. See docs/labels.md."""
