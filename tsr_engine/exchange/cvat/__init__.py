"""CVAT's XML, version 1.1: for video (tracks) and for images (boxes by picture), of one task or of a project."""
