"""Many drives in one call: each in a process of its own, on this machine or on a Ray cluster. See docs/batch.md."""
