"""Files that are made from runs in the background and can be downloaded: exports, recordings, bundles, 3-D pages."""
