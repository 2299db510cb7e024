"""The routes under ``/api``: thin, typed, each with the failures it can give."""
