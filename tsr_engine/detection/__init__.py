"""The offline detector: boosted trees, soft cascade, spatial prior."""
