"""Label sets: the labels that signs can have, in any country. See docs/labels.md."""
