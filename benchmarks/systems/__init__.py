"""The other systems of the paper's comparison, trained on the same scenes and used through the same interface."""
