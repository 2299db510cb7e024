"""A made-up drive of an hour and a half with its run, created in under two minutes, to measure the page.

``python -m tests.app.long_run --home DIR`` puts a video of 132,400 frames and a complete run with 5,000 confirmed
tracks into the data folder DIR. The evidence has the engine's schema, without pixels; the video is a short segment,
encoded once and repeated.
"""

from __future__ import annotations

import argparse
import json
import sqlite3
import time
import uuid
from dataclasses import dataclass, replace
from fractions import Fraction
from operator import itemgetter
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np

from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Run, Video
from app.videos.packed_table import pack
from tsr_engine.evidence import EvidenceWriter, RunHeader, VideoIdentity
from tsr_engine.evidence.schema import BY_NAME, DATABASE
from tsr_engine.io.opened_file import stamp_of
from tsr_engine.io.video import open_video
from tsr_engine.io.video_probe import video_sha256
from tsr_engine.params import Params
from tsr_engine.recognition.gtsrb_classes import SIGN_CLASSES

FRAMES, TRACKS = 132_400, 5_000
WIDTH, HEIGHT, RATE = 320, 180, 25
SEGMENT = 1_324
_KEY_EVERY = 12

Rows = dict[str, list[tuple[Any, ...]]]


@dataclass(frozen=True)
class LongRun:
    """The data folder and ids of the created run."""

    home: Path
    video_id: str
    run_id: str
    folder: Path


def make_long_run(home: Path, frames: int = FRAMES, tracks: int = TRACKS, seed: int = 1) -> LongRun:
    """Create the video, the evidence, and the rows of the database.

    Args:
        home: data folder; created if missing.
        frames: length, a multiple of ``SEGMENT`` or shorter than it.
        tracks: confirmed tracks.
        seed: of all random choices.
    """
    home.mkdir(parents=True, exist_ok=True)
    database = Database(Settings(home=home).database)
    database.migrate()
    path = write_video(home / "long_drive.mp4", frames)
    digest = video_sha256(path)
    with open_video(path) as video:
        # Our file matches its packets; decoding it to confirm that would take most of the time.
        table = replace(video.table, confirmed=len(video.table), complete=True)
    run_id = uuid.uuid4().hex
    folder = home / "runs" / run_id
    header = RunHeader(
        video=VideoIdentity(path.name, digest, path.stat().st_size),
        parameters=Params().model_dump(mode="json"),
        models={"classifier": "0" * 64},
        frame_table={"time_base": "1/12800", "frames": frames, "width": WIDTH, "height": HEIGHT, "interval": 1 / RATE},
        keep_pixels=False,
    )
    write_evidence(folder, header, frames, tracks, seed)
    with database.write() as session:
        if session.get(Video, digest) is None:
            session.add(
                Video(
                    id=digest,
                    name=path.name,
                    path=str(path),
                    size=path.stat().st_size,
                    state="ready",
                    width=WIDTH,
                    height=HEIGHT,
                    rotation=0,
                    codec="h264",
                    rate=float(RATE),
                    frames=len(table),
                    duration=len(table) / RATE,
                    warnings=[],
                    frame_table=pack(table),
                    stamp=list(stamp_of(path.stat())),  # as an import leaves it
                )
            )
            session.flush()
        session.add(
            Run(
                id=run_id,
                video_id=digest,
                kind="engine",
                name="Long run",
                state="complete",
                preset="default",
                parameters={},
                folder=f"runs/{run_id}",
                frames_done=frames,
                frames_total=frames,
                tracks=tracks,
                rate=50.0,
                models={},
                summary={},
            )
        )
    database.close()
    return LongRun(home, digest, run_id, folder)


def write_video(path: Path, frames: int) -> Path:
    """A video of ``frames`` frames: a segment with burnt-in numbers, repeated without encoding it again."""
    length = min(SEGMENT, frames)
    if frames % length:
        raise ValueError(f"The length must be a multiple of {length}. Got {frames}.")
    with av.open(str(path), "w") as out:
        stream = out.add_stream("libx264", rate=RATE, options={"preset": "ultrafast", "crf": "30", "bf": "0"})
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        stream.gop_size = _KEY_EVERY
        stream.codec_context.options = {"preset": "ultrafast", "crf": "30", "bf": "0", "sc_threshold": "0"}
        packets = []
        for k in range(length):
            frame = av.VideoFrame.from_ndarray(_picture(k), format="bgr24")
            frame.pts, frame.time_base = k, Fraction(1, RATE)
            packets += stream.encode(frame)
        packets += stream.encode(None)
        ticks = Fraction(1, RATE) / packets[0].time_base
        segment = [(bytes(p), int(p.pts), int(p.dts), p.is_keyframe) for p in packets]
        base = packets[0].time_base
        for repeat in range(frames // length):
            shift = int(repeat * length * ticks)
            for content, pts, dts, key in segment:
                packet = av.Packet(content)
                packet.stream, packet.time_base = stream, base
                packet.pts, packet.dts, packet.is_keyframe = pts + shift, dts + shift, key
                packet.duration = int(ticks)
                out.mux(packet)
    return path


def _picture(k: int) -> np.ndarray:
    picture = np.full((HEIGHT, WIDTH, 3), (120, 110, 100), np.uint8)
    picture[HEIGHT // 2 :] = (70, 72, 74)
    for i in range(6):
        depth = ((i * 30 + k * 3) % 180) / 180
        y = int(HEIGHT / 2 + HEIGHT / 2 * depth**2)
        cv2.line(picture, (WIDTH // 2, y), (WIDTH // 2, min(HEIGHT, y + int(12 * depth) + 1)), (220, 220, 220), 2)
    cv2.putText(picture, str(k), (8, 24), cv2.FONT_HERSHEY_SIMPLEX, 0.7, (255, 255, 255), 2)
    return picture


def write_evidence(folder: Path, header: RunHeader, frames: int, tracks: int, seed: int) -> None:
    """The evidence of a made-up run, straight into the engine's tables."""
    rng = np.random.default_rng(seed)
    EvidenceWriter.create(folder, header).close("complete")
    rows: Rows = {name: [] for name in BY_NAME if name != "meta"}
    alive = np.zeros(frames, np.int64)
    starts = np.sort(rng.integers(0, frames - 70, tracks))
    for number, start in enumerate(starts.tolist(), start=1):
        _track(rows, rng, number, start, alive)
    _renumber(rows)
    seconds = (np.arange(frames) / RATE).tolist()
    shift = rng.normal(0, 0.4, (frames, 2)).tolist()
    for k in range(frames):
        key = int(k % SEGMENT % _KEY_EVERY == 0)
        rows["frames"].append((k, seconds[k], WIDTH, HEIGHT, *shift[k], k * 512, key, 0, int(alive[k])))
    connection = sqlite3.connect(folder / DATABASE, isolation_level=None)
    connection.execute("PRAGMA synchronous = OFF")
    connection.execute("BEGIN")
    for name, table in rows.items():
        # Clustered tables fill fastest in key order.
        table.sort(key=itemgetter(*range(len(BY_NAME[name].key))))
        connection.executemany(BY_NAME[name].insert(), table)
    connection.execute("COMMIT")
    connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    connection.close()


def _renumber(rows: Rows) -> None:
    """Number rows within a frame from 0; detections have track numbers until here."""
    count: dict[int, int] = {}
    place: dict[tuple[int, int], int] = {}
    detections = []
    for row in rows["detections"]:
        place[row[0], row[1]] = count[row[0]] = count.get(row[0], -1) + 1
        detections.append((row[0], count[row[0]], *row[2:]))
    rows["detections"] = detections
    rows["track_frames"] = [
        (*row[:10], None if row[10] is None else place[row[0], row[1]]) for row in rows["track_frames"]
    ]
    for name, part in (("track_frames", 2), ("events", 1)):
        position: dict[int, int] = {}
        numbered = []
        for row in sorted(rows[name], key=lambda row: row[:2]):
            position[row[0]] = position.get(row[0], -1) + 1
            numbered.append((*row[:part], position[row[0]], *row[part + 1 :]))
        rows[name] = numbered


def _track(rows: Rows, rng: np.random.Generator, number: int, start: int, alive: np.ndarray) -> None:
    """One approaching sign that leaves the picture sideways."""
    length = int(np.clip(rng.normal(26, 9), 6, 62))
    tau, label = 15.0, int(rng.integers(43))
    rival = int((label + rng.integers(1, 43)) % 43)
    t = np.arange(length)
    growth = 1.0 + rng.uniform(0.01, 0.05) * t
    side = rng.uniform(8, 16) * growth
    offset = np.array([rng.choice([-1, 1]) * rng.uniform(20, 60), rng.uniform(-40, 5)])
    centre = np.array([WIDTH / 2, HEIGHT / 2]) + offset * growth[:, None] + rng.normal(0, 0.4, (length, 2))
    box = np.column_stack([centre - side[:, None] / 2, centre + side[:, None] / 2])
    predicted = box + rng.normal(0, 0.8, (length, 1))
    loss = np.exp(rng.normal(1.2, 1.1, length))
    magnitude = np.clip(rng.normal(0.6, 0.15, length), 0.05, 1.0)
    symmetry = 1 / np.maximum(magnitude, 0.6)
    bits = rng.integers(0, 30, length).astype(float)
    bits[bits == 0] = 1.0
    seen = rng.random(length) < 0.85
    seen[:3] = True
    source = np.where(
        seen, "detected", np.where((loss >= tau) | (rng.random(length) < 0.2), "relocalised", "predicted")
    )
    raw, prior = rng.normal(3, 1.5, length), rng.uniform(0.2, 0.95, length)
    score = raw + (prior - 0.5) * 2.0
    weight = 0.02 * np.exp(-(np.minimum(side - 48, 0) ** 2) / 800)
    p = rng.dirichlet(np.full(43, 0.02), length)
    p[:, label] += rng.uniform(0.5, 3.0)
    p[:, rival] += rng.uniform(0.0, 1.4) * (rng.random(length) < 0.7)
    p = (p / p.sum(axis=1, keepdims=True)).astype(np.float32)
    votes = np.cumsum(weight[:, None] * p.astype(np.float64), axis=0)
    order = np.argsort(-votes, axis=1, kind="stable")
    total = votes.sum(axis=1)
    covariance = np.ascontiguousarray(np.diag([4.0, 4.0, 2.0, 2.0]), "<f8").tobytes()
    alive[start : start + length] += 1
    name = SIGN_CLASSES[label].name
    for i in range(length):
        k, key = start + i, (start + i, number)
        state = "tentative" if i < 2 else "confirmed"
        edges = box[i].tolist()
        if source[i] == "detected":
            rows["detections"].append((k, number, *edges, float(raw[i]), float(prior[i]), float(score[i])))
        detection = number if source[i] == "detected" else None
        rows["track_frames"].append((*key, 0, state, str(source[i]), *edges, float(score[i]), detection))
        if i:
            rows["predictions"].append((*key, *predicted[i].tolist(), covariance))
            distance = float(loss[i] / (symmetry[i] * bits[i]))
            factors = (float(magnitude[i]), float(symmetry[i]), float(bits[i]), distance, float(loss[i]))
            rows["gates"].append((*key, *factors, int(loss[i] < tau)))
            rows["samples"].append((*key, 0, "learned", 1 if loss[i] < tau else -1, "prediction", k))
            if loss[i] >= tau and source[i] == "detected":
                text = f"Prediction of track {number} rejected, L = {loss[i]:.1f} > 15; its detection counts."
                rows["events"].append((k, 0, number, "rejected", text, json.dumps({"l_positive": float(loss[i])})))
        if source[i] == "relocalised":
            x1, y1, x2, y2 = predicted[i].tolist()
            search = (x1 - 20, y1 - 20, x2 + 20, y2 + 20)
            rows["relocalisations"].append((*key, *search, *edges, 1.2, 0.77, x1 + 9, y1, x2 + 9, y2, 0.1, 441))
            text = f"Prediction of track {number} rejected, L = {loss[i]:.1f}; relocalised 1 px left."
            rows["events"].append((k, 0, number, "relocalised", text, "{}"))
        best, second = int(order[i, 0]), int(order[i, 1])
        share = float(votes[i, best] / total[i])
        blob, ballot = p[i].astype("<f4").tobytes(), votes[i].astype("<f8").tobytes()
        rows["recognitions"].append((*key, blob, float(side[i]), float(weight[i]), ballot, best, share, second))
    rows["events"].append((start, 0, number, "born", f"Track {number} starts.", "{}"))
    rows["events"].append((start + 2, 0, number, "confirmed", f"Track {number} is confirmed: '{name}'.", "{}"))
    best = int(order[-1, 0])
    rows["tracks"].append(
        (
            number,
            start,
            start + length - 1,
            length,
            int((source == "detected").sum()),
            start + 2,
            float(score.max()),
            float(side.max()),
            best,
            float(votes[-1, best] / total[-1]),
        )
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--home", type=Path, required=True, help="data folder to put video and run into")
    parser.add_argument("--frames", type=int, default=FRAMES)
    parser.add_argument("--tracks", type=int, default=TRACKS)
    given = parser.parse_args()
    began = time.perf_counter()
    made = make_long_run(given.home.absolute(), given.frames, given.tracks)
    print(f"video {made.video_id}\nrun {made.run_id}\n{time.perf_counter() - began:.1f} s")


if __name__ == "__main__":
    main()
