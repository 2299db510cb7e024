"""Annotates signs of GTSDB's training scenes that ``gt.txt`` lacks: finds, names and measures them."""
