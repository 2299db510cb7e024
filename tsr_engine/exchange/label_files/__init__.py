"""Label sets in the files of other tools: which names they have, and what is known about each. See docs/labels.md."""
