"""Trains the models: on public data (``public``), and further on corrections of people (``corrections``).

Both draw on views and drawings of signs (``synthetic``). Here is what they share: progress and the report of a version.
"""
