"""The other systems of the paper's comparison, trained on the same scenes and run through the same seam."""
