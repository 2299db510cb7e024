"""Pascal VOC: one XML file a picture.

Corners are written in two ways. The devkit counts pixels from 1 and both corners belong to the sign; CVAT and Datumaro
write edges from 0. The switch ``coordinates`` selects one; only the upper left corner differs, by 1.
"""
