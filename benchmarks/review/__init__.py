"""Measures the review tool as a user has it: with a real server, a real browser and a real drive."""
