"""Any YOLO-style network in ONNX form as the offline detector.

The output has one of two layouts, which the caller names:

* ``"v8"``: ``(1, 4 + classes, n)``: centre and size in input px, class probabilities;
* ``"v5"``: ``(1, n, 5 + classes)``: centre and size, objectness, class probabilities.

The score of a box is its best class probability (times objectness); it becomes log-odds, so thresholds, prior and
evidence mean the same as with the ACF detector.
"""

from __future__ import annotations

from threading import Lock
from typing import Final, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.channels.compute import check_picture
from tsr_engine.detection.nms import suppress
from tsr_engine.detection.onnx_external_files import refers_to_files
from tsr_engine.detection.prior import SpatialPrior, effective_weight, with_prior
from tsr_engine.geometry.boxes import MIN_SIDE, clip, shorter_side
from tsr_engine.params.detector import DetectorParams, PriorParams
from tsr_engine.records import Detections, FloatArray, Picture

Layout = Literal["v8", "v5"]
GREY: Final = 114
"""Grey value of the input where the picture does not cover it."""


class OnnxDetector:
    """A network run by OpenCV; implements :class:`tsr_engine.protocols.OfflineDetector`."""

    name = "onnx"

    def __init__(
        self,
        network: bytes,
        size: tuple[int, int],
        layout: Layout = "v8",
        prior: SpatialPrior | None = None,
        params: DetectorParams | None = None,
        prior_params: PriorParams | None = None,
    ) -> None:
        """Load a network.

        Args:
            network: the ONNX file's content.
            size: (width, height) of the network's input, px.
            layout: layout of its output.
            prior: spatial prior of signs; unset: no prior.
            params: parameters of the detector; only ``keep_score`` and ``final_overlap`` are used.
            prior_params: parameters of the prior.

        Raises:
            ValueError: OpenCV cannot read the network, or it refers to other files.
        """
        if refers_to_files(network):
            raise ValueError("Expected an ONNX network that is one file. Got one whose weights lie in other files.")
        try:
            self._net = cv2.dnn.readNetFromONNX(np.frombuffer(network, np.uint8))
        except cv2.error as error:
            raise ValueError(f"Expected an ONNX network that OpenCV reads. Got: {error.err}.") from None
        self._lock = Lock()
        self._size = size
        self._layout = layout
        self.prior = prior
        self.params = params or DetectorParams()
        self.prior_params = prior_params or PriorParams()

    def detect(self, picture: Picture) -> Detections:
        """Detections of one BGR picture, best final score first.

        Raises:
            ValueError: the picture is not uint8 of shape (h, w, 3) or has no pixel, or the network's output has another
                layout.
        """
        check_picture(picture)
        height, width = picture.shape[:2]
        canvas, scale, offset = letterbox(picture, self._size)
        with self._lock:  # a network of OpenCV is not thread-safe
            self._net.setInput(cv2.dnn.blobFromImage(canvas, 1 / 255.0, swapRB=True))
            boxes, confidence = decode(np.asarray(self._net.forward()), self._layout)
        boxes = (boxes - np.array([*offset, *offset])) / scale
        clipped = np.clip(confidence, 1e-6, 1 - 1e-6)
        raw = np.log(clipped / (1 - clipped))
        kept = raw >= self.params.keep_score
        boxes, raw = clip(boxes[kept], width, height), raw[kept]
        is_large_enough = shorter_side(boxes) >= MIN_SIDE  # boxes in the grey bars have no area after clipping
        boxes, raw = boxes[is_large_enough], raw[is_large_enough]
        prior = np.full(len(raw), 0.5) if self.prior is None else self.prior.at(boxes, width, height)
        final = with_prior(raw, prior, effective_weight(self.prior, self.prior_params))
        order = suppress(boxes, final, self.params.final_overlap)
        return Detections(boxes[order], raw[order], prior[order], final[order])


def letterbox(picture: Picture, size: tuple[int, int]) -> tuple[Picture, float, tuple[float, float]]:
    """Scale a picture to fit (width, height), centred on grey; returns it with the scale and the (x, y) offset, px."""
    width, height = size
    scale = min(width / picture.shape[1], height / picture.shape[0])
    inner = (max(1, round(picture.shape[1] * scale)), max(1, round(picture.shape[0] * scale)))
    x, y = (width - inner[0]) // 2, (height - inner[1]) // 2
    canvas = np.full((height, width, 3), GREY, np.uint8)
    shrinking = scale < 1
    canvas[y : y + inner[1], x : x + inner[0]] = cv2.resize(
        picture, inner, interpolation=cv2.INTER_AREA if shrinking else cv2.INTER_LINEAR
    )
    return canvas, scale, (float(x), float(y))


def decode(output: NDArray[np.float32], layout: Layout) -> tuple[FloatArray, FloatArray]:
    """Boxes (n, 4), corners in input px, and confidences (n,) of a network's output.

    Rows with a value that is not finite are left out, since a network of half precision may overflow.

    Raises:
        ValueError: the output does not have the layout's shape.
    """
    rows = output[0].T if layout == "v8" and output.ndim == 3 else output[0] if output.ndim == 3 else output
    min_columns = 5 if layout == "v8" else 6
    if output.ndim != 3 or output.shape[0] != 1 or rows.shape[1] < min_columns:
        raise ValueError(f"Expected a '{layout}' output of one picture and at least one class. Got {output.shape}.")
    if rows.shape[0] < rows.shape[1]:  # a grid has more cells than columns, so this is the other layout, transposed
        raise ValueError(f"Expected more boxes than columns in a '{layout}' output. Got {output.shape}.")
    finite = np.isfinite(rows).all(axis=1)
    rows = (rows if finite.all() else rows[finite]).astype(np.float64)
    confidence = rows[:, 4:].max(axis=1) if layout == "v8" else rows[:, 4] * rows[:, 5:].max(axis=1)
    half = rows[:, 2:4] / 2
    return np.concatenate([rows[:, :2] - half, rows[:, :2] + half], axis=1), confidence
