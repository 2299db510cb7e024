"""Measuring time and memory: contenders in turn, and drives as long as one likes."""
