"""GTSDB's ``gt.txt``: ``file;left;top;right;bottom;class``, whole pixels, one row a sign, no header.

The benchmark does not say whether right and bottom belong to the sign. On its pictures the inclusive reading fits
(``tsr_engine.io.gtsdb``), so it is the default of the switch ``corners``. The manifest records the reading.
Pictures without signs have no row, so ``pictures.txt`` lists all pictures.
"""
