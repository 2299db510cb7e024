"""The online detector: incremental SVM and relocalisation."""
