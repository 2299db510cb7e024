"""Annotated clips and simulated approaches, their stored detections, and the engine's tracks on them."""
