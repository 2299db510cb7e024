"""Bug bundles of the tool's runs: made with one button, and taken in from other people."""
