"""Labels of the metric scene have names and do not overlap."""

from __future__ import annotations

import numpy as np

from app.scene3d.label_spread import (
    FIELD_OF_VIEW_RAD,
    LABEL_HEIGHT_PX,
    LETTER_WIDTH_PX,
    VIEW_HEIGHT_PX,
    label_offsets,
    label_text,
)

EYE, TARGET = (-8.5, -13.0, 7.5), (1.0, 16.0, -0.5)


def seen(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions of points on the viewer's screen, px."""
    ahead = np.array(TARGET) - np.array(EYE)
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    away = points - np.array(EYE)
    scale = VIEW_HEIGHT_PX / 2 / np.tan(FIELD_OF_VIEW_RAD / 2) / (away @ ahead)
    return away @ right * scale, away @ np.cross(right, ahead) * scale


def test_no_label_covers_another() -> None:
    rng = np.random.default_rng(3)
    post = np.array([3.0, 20.0, 1.0]) + rng.normal(0, 0.3, (6, 3))
    points = np.concatenate([post, rng.uniform([-6, 8, 0], [6, 40, 3], (8, 3))])
    texts = [label_text("speed limit 60 km/h", f"#{i}", "20.0 m") for i in range(len(points))]
    raised = label_offsets(points, texts, EYE, TARGET)
    assert (raised >= 0).all()
    x, y = seen(points + raised[:, None] * [0, 0, 1])
    wide = np.array([len(text) for text in texts]) * LETTER_WIDTH_PX / 2
    for i in range(len(points)):
        for j in range(i):
            # a raised point comes slightly nearer: up to an eighth of a line may overlap
            apart = abs(x[i] - x[j]) >= (wide[i] + wide[j]) * 0.98 or abs(y[i] - y[j]) >= LABEL_HEIGHT_PX * 0.7
            assert apart, (i, j)


def test_a_single_label_does_not_move() -> None:
    assert label_offsets([[0, 10, 1], [8, 30, 1]], ["stop", "stop"], EYE, TARGET).tolist() == [0, 0]
    assert label_offsets(np.zeros((0, 3)), [], EYE, TARGET).tolist() == []
    assert label_offsets([[-8.5, -30, 7]], ["behind"], EYE, TARGET).tolist() == [0]


def test_a_label_names_the_class_and_is_shortened() -> None:
    assert label_text("stop", "#3", "12.0 m") == "stop · #3 · 12.0 m"
    assert label_text("a" * 200, "#3") == "a" * 35 + "… · #3"
