"""Model versions: trained from corrections, promoted, rolled back; and the version of each run."""
