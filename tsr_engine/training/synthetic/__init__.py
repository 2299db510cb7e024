"""Makes training pictures: augmented views of real signs (``*augment*``), drawn signs, and recoloured real signs."""
