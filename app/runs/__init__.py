"""Runs of the engine: started, followed, cancelled, resumed, removed."""
