"""Model versions: made from corrections, promoted, rolled back; and which of them a run uses."""
