"""Classification of crops and fusion of votes over a track."""
