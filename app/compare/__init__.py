"""Compares two versions of one video's annotation: runs, corrected annotations, ground truth."""
