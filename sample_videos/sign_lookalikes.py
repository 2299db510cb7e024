"""Things that look like traffic signs but are not: posters, shop signs, parking plates, mirrors, backs of signs."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from sample_videos.colour import linear_picture
from sample_videos.linear_canvas import Patch
from sample_videos.noise import mipmaps
from tsr_engine.pictograms.canvas import Canvas, arc, rounded
from tsr_engine.pictograms.gtsrb import outline
from tsr_engine.pictograms.paths import path

_N = 256


def _flat(colour: tuple[int, int, int]) -> NDArray[np.uint8]:
    image = np.zeros((_N, _N, 4), np.uint8)
    image[:] = (*colour[::-1], 255)
    return image


def _done(image: NDArray[np.uint8]) -> list[Patch]:
    return mipmaps(linear_picture(image))


def poster(rng: np.random.Generator) -> list[Patch]:
    """An advertisement with coloured discs and bars."""
    image = _flat([(222, 196, 60), (214, 214, 208), (40, 96, 150), (196, 60, 52)][int(rng.integers(4))])
    centre = (int(rng.uniform(60, 120)), int(rng.uniform(90, 160)))
    cv2.circle(image, centre, 62, (*[int(v) for v in rng.integers(20, 235, 3)], 255), -1, cv2.LINE_AA)
    cv2.circle(image, centre, 40, (230, 232, 232, 255), -1, cv2.LINE_AA)
    cv2.circle(image, centre, 22, (40, 40, 180, 255), -1, cv2.LINE_AA)
    for k, y in enumerate(range(60, 220, 34)):
        width = int(rng.uniform(50, 95))
        cv2.rectangle(image, (150, y), (150 + width, y + (20 if k == 0 else 10)), (38, 36, 36, 255), -1)
    cv2.rectangle(image, (0, 0), (_N - 1, _N - 1), (120, 122, 122, 255), 8)
    return _done(image)


def shop_disc(rng: np.random.Generator) -> list[Patch]:
    """A round shop sign with a ring and a letter-like stroke."""
    canvas = Canvas()
    ring, inner = [((176, 28, 34), (236, 226, 190)), ((20, 80, 150), (226, 190, 40)), ((30, 120, 70), (234, 234, 228))][
        int(rng.integers(3))
    ]
    canvas.outline(arc(0, 0, 0.98, 0.98, 0, 360, 90))
    canvas.disc(0, 0, 1, ring)
    canvas.disc(0, 0, 0.66, inner)
    canvas.stroke(arc(0, 0, 0.36, 0.36, 40, 320, 40), 0.16, ring, caps=True)
    return _done(canvas.picture(_N))


def parking() -> list[Patch]:
    """A blue parking plate."""
    canvas = Canvas()
    plate = rounded(path("-98 -98 98 -98 98 98 -98 98"), 0.14)
    canvas.outline(plate)
    canvas.fill(plate, (236, 238, 236))
    canvas.fill(plate * 0.93, (12, 72, 150))
    canvas.fill("-34 -62 -12 -62 -12 62 -34 62", (236, 238, 236))
    canvas.stroke(
        np.concatenate([path("-20 -52"), arc(0.1, -0.2, 0.32, 0.32, -90, 90), path("-20 12")]), 0.2, (236, 238, 236)
    )
    return _done(canvas.picture(_N))


def direction(rng: np.random.Generator) -> list[Patch]:
    """A yellow or blue signpost plate with bars for names; twice as wide as high when it is put up."""
    yellow = bool(rng.random() < 0.5)
    image = _flat((236, 184, 24) if yellow else (20, 74, 148))
    ink = (30, 30, 30, 255) if yellow else (232, 234, 232, 255)
    for y in (60, 150):
        cv2.rectangle(image, (24, y), (24 + int(rng.uniform(110, 170)), y + 38), ink, -1)
        for x in range(44, 190, 22):
            cv2.rectangle(image, (x, y), (x + 5, y + 38), (36, 184, 236, 255) if yellow else (148, 74, 20, 255), -1)
    cv2.rectangle(image, (3, 3), (_N - 4, _N - 4), ink, 5)
    return _done(image)


def place_name() -> list[Patch]:
    """A yellow plate at the entrance of a town."""
    image = _flat((240, 186, 18))
    cv2.rectangle(image, (4, 4), (_N - 5, _N - 5), (26, 26, 26, 255), 6)
    for x, w in ((30, 18), (56, 14), (78, 20), (106, 8), (122, 18), (148, 16), (172, 20), (200, 16)):
        cv2.rectangle(image, (x, 90), (x + w, 170), (26, 26, 26, 255), -1)
        cv2.rectangle(image, (x + w // 3, 108), (x + 2 * w // 3, 138), (18, 186, 240, 255), -1)
    return _done(image)


def mirror() -> list[Patch]:
    """A round traffic mirror in a red and white frame."""
    canvas = Canvas()
    canvas.outline(arc(0, 0, 0.98, 0.98, 0, 360, 90))
    canvas.disc(0, 0, 1, (226, 226, 222))
    for k in range(0, 12, 2):
        wedge = np.concatenate(
            [arc(0, 0, 1.0, 1.0, 30 * k, 30 * k + 30, 8), arc(0, 0, 0.8, 0.8, 30 * k + 30, 30 * k, 8)]
        )
        canvas.fill(wedge, (190, 40, 36))
    canvas.disc(0, 0, 0.82, (148, 168, 186))
    canvas.fill(np.concatenate([arc(0, 0, 0.82, 0.82, 10, 170, 40)]), (88, 92, 86))
    canvas.fill("-10 14 12 14 40 72 -30 76", (112, 112, 112))
    return _done(canvas.picture(_N))


def sign_back(class_id: int) -> list[Patch]:
    """The grey back of a sign for oncoming traffic."""
    canvas = Canvas()
    shape = outline(class_id)
    canvas.outline(shape)
    canvas.fill(shape * 1.1, (122, 124, 124))
    canvas.fill(shape * 0.95, (134, 136, 137))
    canvas.fill("-100 -16 100 -16 100 -8 -100 -8", (112, 114, 114))
    canvas.fill("-100 26 100 26 100 34 -100 34", (112, 114, 114))
    return _done(canvas.picture(_N))


def chevrons() -> list[Patch]:
    """A red and white bend marker."""
    image = _flat((228, 228, 224))
    for x in (-20, 92, 204):
        points = np.array([[x, 0], [x + 56, 0], [x + 106, 128], [x + 56, 256], [x, 256], [x + 50, 128]])
        cv2.fillPoly(image, [points], (34, 24, 188, 255), cv2.LINE_AA)
    return _done(image)
