"""Training from scenes and crops."""
