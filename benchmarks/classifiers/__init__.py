"""Classifiers that are trained without some of GTSRB's signs, to measure them on those."""
