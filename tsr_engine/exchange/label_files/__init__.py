"""Label sets in the files of other tools: their names, and what is known about each. See docs/labels.md."""
