"""Two views of one video side by side: runs, corrected annotations, ground truth."""
