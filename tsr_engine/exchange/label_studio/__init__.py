"""Label Studio video JSON: one region a track, key frames in percent of the picture.

Frames count from 1 and a frame's time is its number divided by the frame rate, so only videos of constant rate fit.
``enabled: false`` hides a region after that key frame until its next one. ``videorectangle.md`` of Label Studio's
documentation describes the format.
"""
