"""Measures time and memory: alternating contenders, and drives of any length."""
