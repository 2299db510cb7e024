"""Motion models, association and track life cycle."""
