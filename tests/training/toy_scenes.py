"""Small scenes with drawn discs and triangles on natural noise, in the layout of GTSDB."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np


def backdrop(rng: np.random.Generator, height: int, width: int) -> np.ndarray:
    fy, fx = np.fft.fftfreq(height)[:, None], np.fft.fftfreq(width)[None]
    f = np.hypot(fy, fx)
    f[0, 0] = 1
    planes = [np.real(np.fft.ifft2(np.fft.fft2(rng.normal(size=(height, width))) / f)) for _ in range(3)]
    return np.stack([(p - p.min()) / np.ptp(p) * 200 + 20 for p in planes], -1).astype(np.uint8)


def draw_sign(picture: np.ndarray, cx: float, cy: float, side: float, kind: int) -> None:
    shift = 4
    one = 1 << shift
    at = (round(cx * one), round(cy * one))
    if kind == 0:
        cv2.circle(picture, at, round(side / 2 * one), (40, 30, 200), -1, cv2.LINE_AA, shift)
        cv2.circle(picture, at, round(side * 0.36 * one), (235, 235, 235), -1, cv2.LINE_AA, shift)
        cv2.circle(picture, at, round(side * 0.12 * one), (20, 20, 20), -1, cv2.LINE_AA, shift)
    else:
        cv2.circle(picture, at, round(side / 2 * one), (200, 90, 10), -1, cv2.LINE_AA, shift)
        half = round(side * 0.09 * one)
        tall = round(side * 0.33 * one)
        cv2.rectangle(
            picture, (at[0] - half, at[1] - tall), (at[0] + half, at[1] + tall), (240, 240, 240), -1, cv2.LINE_AA, shift
        )


def make_scene(rng: np.random.Generator, height: int = 200, width: int = 260) -> tuple[np.ndarray, list[list[float]]]:
    """A picture and rows ``x1, y1, x2, y2, class``; signs lie in the right half, so that a prior can help."""
    picture = backdrop(rng, height, width)
    rows: list[list[float]] = []
    for _ in range(int(rng.integers(1, 3))):
        side = float(rng.uniform(18, 46))
        cx, cy = rng.uniform(width / 2 + 25, width - 25), rng.uniform(40, height - 40)
        if any(abs(cx - (r[0] + r[2]) / 2) < 55 and abs(cy - (r[1] + r[3]) / 2) < 55 for r in rows):
            continue
        kind = int(rng.integers(2))
        draw_sign(picture, cx, cy, side, kind)
        rows.append([cx - side / 2, cy - side / 2, cx + side / 2, cy + side / 2, 2 if kind == 0 else 35])
    return picture, rows


def write_gtsdb(folder: Path, count: int, seed: int) -> Path:
    rng = np.random.default_rng(seed)
    folder.mkdir(parents=True, exist_ok=True)
    lines = []
    for k in range(count):
        picture, rows = make_scene(rng)
        cv2.imwrite(str(folder / f"{k:05d}.png"), picture)
        lines += [f"{k:05d}.png;{round(a)};{round(b)};{round(c) - 1};{round(d) - 1};{int(e)}" for a, b, c, d, e in rows]
    (folder / "gt.txt").write_text("\n".join(lines) + "\n")
    return folder
