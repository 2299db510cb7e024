"""Label sets: what signs can be called, in any country. See docs/labels.md."""
