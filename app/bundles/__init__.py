"""Bug bundles of the tool's runs: export with one button, and import from other people."""
