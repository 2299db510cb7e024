"""MOT 1.1: rows of boxes with track ids, one folder a sequence.

Frames, track ids and classes count from 1. Positions count from 0, as in CVAT and Datumaro, or with ``origin=1`` from
1, as in MOTChallenge. Source: motchallenge.net, instructions; ``format-mot.md`` of CVAT's documentation.
"""
