"""One contract for every format: exported data is imported unchanged, except for its losses in the table."""

from __future__ import annotations

import hashlib
import json
import string
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.exchange.losses import LOSSES, compare
from tests.exchange.small_datasets import GTSRB, make_track, make_video, target_of, tracks_of, write_grey_video
from tsr_engine.exchange.added_labels import UnknownLabels
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Track
from tsr_engine.exchange.export import CROP_FORMATS, export_dataset
from tsr_engine.exchange.formats import ExportOptions, Format, ImportTarget
from tsr_engine.exchange.labels import label_name
from tsr_engine.exchange.load import detect_format, read_dataset
from tsr_engine.exchange.manifest import read_manifest
from tsr_engine.exchange.registry import FORMATS
from tsr_engine.exchange.split import make_split
from tsr_engine.labels.model import Attribute, Label, LabelSet

WIDTH, HEIGHT, FRAMES = 64, 48, 16

ATTRIBUTES = tuple(
    Attribute(name=f"{name}{' now' if mutable else ''}", kind=kind, mutable=mutable, values=values)
    for name, kind, values in (
        ("lit", "checkbox", ()),
        ("height", "number", ()),
        ("side", "select", ("left", "right")),
        ("text <&>", "text", ()),
        ("state", "select", ("left", "right")),  # some formats use this name otherwise
        ("box", "text", ()),
    )
    for mutable in (False, True)
)
FOREIGN = (43, 44, 45)
"""Labels that the German benchmark does not have, with questions of every kind."""
LABELS = (-1, 0, 1, 7, 14, 42, *FOREIGN)
SET = LabelSet(
    key="ours",
    name="ours",
    next_id=46,
    labels=(
        *GTSRB,
        Label(id=43, key="pedestrian-crossing", name="pedestrian_crossing", attributes=ATTRIBUTES, colour="#1e90ff"),
        Label(id=44, key="гребля", name="Überweg, 'é' [№ 5]", attributes=ATTRIBUTES),
        Label(id=45, key="limit-7", name="7", attributes=ATTRIBUTES[:1]),
    ),
)

_TEXT = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Cn", "Co", "Zl", "Zp"), exclude_characters="\ufeff"),
    min_size=1,
    max_size=8,
).filter(lambda text: text == text.strip())


def test_the_table_names_every_format() -> None:
    assert set(LOSSES) == set(FORMATS)
    assert all(known.write is not None and known.read is not None for known in FORMATS.values())


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_grey_video(tmp_path_factory.mktemp("contract") / "drive.mp4", WIDTH, HEIGHT, FRAMES)


def _video(clip: Path, tracks: list[Track], name: str = "drive.mp4", sha: str = "a" * 64) -> DatasetVideo:
    made = make_video(tracks, frames=FRAMES, name=name, sha=sha)
    return replace(made, width=WIDTH, height=HEIGHT, path=clip)


@st.composite
def _tracks(draw: st.DrawFn) -> list[Track]:
    uids = draw(st.lists(_TEXT, max_size=3, unique_by=lambda text: text.casefold()))
    return [draw(_track(uid)) for uid in uids]


@st.composite
def _track(draw: st.DrawFn, uid: str) -> Track:
    frames = sorted(draw(st.sets(st.integers(0, FRAMES - 1), min_size=1, max_size=8)))
    n = len(frames)

    def flags() -> np.ndarray:
        return np.array(draw(st.lists(st.booleans(), min_size=n, max_size=n)), dtype=np.bool_)

    boxes = []
    for _ in frames:
        x = draw(st.floats(0, WIDTH - 2, allow_subnormal=False))
        y = draw(st.floats(0, HEIGHT - 2, allow_subnormal=False))
        boxes.append((x, y, x + draw(st.floats(2, WIDTH)), y + draw(st.floats(2, HEIGHT))))
    edges = np.clip(np.array(boxes), 0, (WIDTH, HEIGHT, WIDTH, HEIGHT))
    label = draw(st.sampled_from(LABELS))
    labels = None
    if draw(st.booleans()):
        labels = np.array(draw(st.lists(st.sampled_from((label, label, -1, 7)), min_size=n, max_size=n)))
        # The class of a track is that of most of its frames; formats with classes by frame have nothing else.
        labels[: n // 2 + 1] = label
        labels = None if (labels == label).all() else labels
    score = np.array(draw(st.lists(st.sampled_from((np.nan, 0.0, 0.25, 0.5, 1.0)), min_size=n, max_size=n)))
    ignore = flags() if draw(st.booleans()) else None
    return Track(
        uid,
        label,
        np.array(frames, dtype=np.int64),
        edges,
        flags(),
        flags(),
        score,
        labels=labels,
        ignore=ignore if ignore is not None and ignore.any() else None,
        state=draw(st.sampled_from(("open", "accepted", "rejected", "needs_work"))),
        source=draw(st.sampled_from(("engine", "corrected", "human"))),
        notes=tuple((frames[0], note) for note in draw(st.lists(_TEXT, max_size=2))),
        attributes=draw(_answers(label, n, mutable=False)),
        changing=draw(_answers(label, n, mutable=True)),
    )


@st.composite
def _answers(draw: st.DrawFn, label: int, n: int, *, mutable: bool) -> dict[str, Any]:
    """Answers to some of the questions of a label."""
    kinds = {
        "checkbox": st.booleans(),
        "number": st.sampled_from((-1.5, 0.0, 7.0, 123456.25)),
        "select": st.sampled_from(("left", "right")),
        "text": _TEXT,
    }
    out: dict[str, Any] = {}
    for asked in ATTRIBUTES if label in FOREIGN[:2] else ():
        if asked.mutable != mutable or not draw(st.booleans()):
            continue
        answer = kinds[asked.kind]
        if not mutable:
            out[asked.name] = draw(answer)
            continue
        values = np.full(n, None, object)
        values[:] = draw(st.lists(st.none() | answer, min_size=n, max_size=n))
        if any(value is not None for value in values):
            out[asked.name] = values
    return out


def _options(known: Format, **more: object) -> ExportOptions:
    pictures = "annotated" if known.needs_pictures else "none"
    return ExportOptions(pictures=pictures, thin_px=0.0, **more)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", list(FORMATS))
@settings(max_examples=8, deadline=None, suppress_health_check=list(HealthCheck))
@given(tracks=_tracks())
def test_exports_round_trip(name: str, clip: Path, tracks: list[Track]) -> None:
    dataset = Dataset(SET, (_video(clip, tracks),))
    with TemporaryDirectory() as folder:
        out = Path(folder) / "export.zip"
        export_dataset(dataset, FORMATS[name], out, _options(FORMATS[name]), zipped=True)
        compare(dataset, read_dataset(out, target_of(dataset), FORMATS[name]), LOSSES[name])


@pytest.mark.parametrize("name", [name for name, known in FORMATS.items() if known.write and not known.needs_pictures])
def test_the_image_option_changes_files_as_documented(name: str, clip: Path, tmp_path: Path) -> None:
    known = FORMATS[name]
    for switch in (switch for switch in known.export_switches if switch.name == "image"):
        written = []
        for value in switch.values:
            out = tmp_path / value
            export_dataset(_plain(clip), known, out, _options(known, switches={"image": value}), zipped=False)
            texts = (path for path in sorted(out.rglob("*")) if path.is_file() and path.name != "manifest.json")
            written.append([path.read_bytes() for path in texts])
        assert (written[0] != written[1]) == ("without pictures" in switch.help)


def _plain(clip: Path) -> Dataset:
    """Two signs, one with a gap; they overlap for a while."""
    tracks = [
        make_track("m1", [0, 1, 2, 6, 7], boxes=[(4 + k, 5, 20 + k, 21) for k in range(5)]),
        make_track("m2", [2, 3, 4], label=1, boxes=[(40, 20 + k, 52, 32 + k) for k in range(3)]),
        make_track("h1", [12, 13], label=33, boxes=[(10, 10, 30.5, 30.25)] * 2),
    ]
    return Dataset(GTSRB, (_video(clip, tracks),))


@pytest.mark.parametrize("name", list(FORMATS))
def test_the_same_data_gives_the_same_bytes(name: str, clip: Path, tmp_path: Path) -> None:
    digests = set()
    for turn in ("first", "second"):
        out = tmp_path / turn / "export.zip"
        export_dataset(_plain(clip), FORMATS[name], out, _options(FORMATS[name]), zipped=True)
        digests.add(hashlib.sha256(out.read_bytes()).hexdigest())
    assert len(digests) == 1


@pytest.mark.parametrize("name", list(FORMATS))
def test_the_bound_of_thinning_applies_to_formats_with_key_frames(name: str, clip: Path, tmp_path: Path) -> None:
    boxes = [(4 + 2 * k, 5, 20 + 2 * k + 0.5 * (k % 2), 21) for k in range(9)]
    dataset = Dataset(GTSRB, (_video(clip, [make_track("m1", range(9), boxes=boxes)]),))
    written = []
    for bound in (0.0, 2.0):
        out = tmp_path / str(bound)
        export_dataset(dataset, FORMATS[name], out, replace(_options(FORMATS[name]), thin_px=bound), zipped=False)
        texts = (path for path in sorted(out.rglob("*")) if path.is_file() and path.name != "manifest.json")
        written.append([path.read_bytes() for path in texts])
    assert (written[0] != written[1]) == FORMATS[name].key_frames


@pytest.mark.parametrize("name", list(FORMATS))
def test_an_empty_data_set(name: str, clip: Path, tmp_path: Path) -> None:
    dataset = Dataset(GTSRB, (_video(clip, []),))
    export_dataset(dataset, FORMATS[name], tmp_path / "out", _options(FORMATS[name]), zipped=False)
    assert read_manifest(tmp_path / "out").counts["boxes"] == 0
    assert not tracks_of(read_dataset(tmp_path / "out", target_of(dataset), FORMATS[name]))


@pytest.mark.parametrize("name", [name for name, loss in LOSSES.items() if not loss.benchmark])
def test_missing_labels_are_added_with_their_attributes(name: str, clip: Path, tmp_path: Path) -> None:
    """An export of one library is imported into another: labels by name, with the attributes of tracks."""
    answers = {"lit": True, "height": 7.0, "side": "right", "text <&>": "é"}
    tracks = [
        make_track(f"m{index}", [index, index + 1], label=label, boxes=[(5 + index, 6, 25, 30)] * 2, attributes=said)
        for index, (label, said) in enumerate(((43, answers), (44, {}), (45, {}), (14, {})), start=1)
    ]
    dataset = Dataset(SET, (_video(clip, tracks),))
    export_dataset(dataset, FORMATS[name], tmp_path / "out", _options(FORMATS[name]), zipped=False)
    onto = ImportTarget(dataset.videos[0], GTSRB)
    with pytest.raises(UnknownLabels) as refused:
        read_dataset(tmp_path / "out", onto, FORMATS[name])
    names = {SET.labels[label].name for label in FOREIGN}
    assert {each.name for each in refused.value.labels} == names
    back = read_dataset(tmp_path / "out", replace(onto, unknown="add"), FORMATS[name])
    assert {label.name for label in back.labels.labels[43:]} == names
    given = {track.frames[0]: track for track in back.videos[0].tracks()}
    called = {frame: label_name(back.labels, track.label) for frame, track in given.items()}
    assert called == {index: SET.labels[label].name for index, label in enumerate((43, 44, 45, 14), start=1)}
    if LOSSES[name].attributes != "none":
        said = {asked: f"{each:g}" if isinstance(each, float) else each for asked, each in given[1].attributes.items()}
        assert said == {**answers, "height": "7"}, "VOC does not say which texts are numbers"


@pytest.mark.parametrize("name", list(FORMATS))
def test_an_export_is_recognised_as_its_format(name: str, clip: Path, tmp_path: Path) -> None:
    export_dataset(_plain(clip), FORMATS[name], tmp_path / "out", _options(FORMATS[name]), zipped=False)
    found = detect_format(tmp_path / "out")
    assert found is not None
    assert found[0].name == name


@pytest.mark.parametrize("name", list(FORMATS))
def test_names_of_any_script(name: str, clip: Path, tmp_path: Path) -> None:
    # formats of benchmarks match classes by key
    names = ("Überholverbot", "停止 # x", 'أ: "ب"', "it's [50], {km/h}")
    labels = GTSRB.model_copy(
        update={"labels": tuple(GTSRB.labels[at].model_copy(update={"name": name}) for at, name in enumerate(names))}
    )
    tracks = [
        make_track(f"прокат-{place}", [place], label=place, boxes=[(5 + place, 6, 25 + place, 30)])
        for place in range(4)
    ]
    dataset = Dataset(labels, (_video(clip, tracks, name="дорога 1.mp4"),))
    export_dataset(dataset, FORMATS[name], tmp_path / "out", _options(FORMATS[name]), zipped=False)
    back = read_dataset(tmp_path / "out", target_of(dataset), FORMATS[name])
    compare(dataset, back, LOSSES[name])


@pytest.mark.parametrize("name", list(FORMATS))
def test_hostile_names_give_a_file_or_a_sentence(name: str, clip: Path, tmp_path: Path) -> None:
    tracks = [
        make_track(uid, [index], boxes=[(5, 6, 25, 30)], notes=((index, uid),))
        for index, uid in enumerate(("=1+1", "../../x", "a\x00b", "\ud800", "line\nbreak", "<a>&amp;", '";DROP', " "))
    ]
    dataset = Dataset(GTSRB, (_video(clip, tracks, name="../../etc/pass\x01wd"),))
    export_dataset(dataset, FORMATS[name], tmp_path / "out", _options(FORMATS[name]), zipped=False)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    allowed = set(string.ascii_letters + string.digits + "-_.")
    assert all(set(path.name) <= allowed for path in (tmp_path / "out").rglob("*"))
    back = read_dataset(tmp_path / "out", target_of(dataset), FORMATS[name])
    assert sum(len(track.frames) for track in back.videos[0].tracks()) == len(tracks)


@pytest.mark.parametrize("name", list(FORMATS))
def test_all_subsets_round_trip(name: str, clip: Path, tmp_path: Path) -> None:
    dataset = _plain(clip)
    rule = "track" if name in CROP_FORMATS else "sign"
    split = make_split(dataset, {"train": 0.6, "val": 0.4}, seed=3, rule=rule)
    assert set(split.values()) == {"train", "val"}
    out = tmp_path / "export.zip"
    reported = export_dataset(dataset, FORMATS[name], out, _options(FORMATS[name], split=split), zipped=True)
    assert set(reported.counts["classes"]) == {"train", "val"}
    compare(dataset, read_dataset(out, target_of(dataset), FORMATS[name]), LOSSES[name])


@pytest.mark.parametrize("name", list(FORMATS))
@pytest.mark.parametrize(
    "names",
    [("a.mp4", "b.mp4"), ("drive.mp4", "night drive.mp4"), ("drive.mp4", "drive.mp4")],
    ids=("other", "alike", "same"),
)
def test_two_videos_of_one_name_get_their_own_tracks(
    name: str, names: tuple[str, str], clip: Path, tmp_path: Path
) -> None:
    videos = [
        _video(clip, [make_track("m1", [k + 1], boxes=[(5.25, 6 + k, 25, 30)])], name=given, sha=str(k) * 64)
        for k, given in enumerate(names)
    ]
    dataset = Dataset(GTSRB, tuple(videos))
    export_dataset(dataset, FORMATS[name], tmp_path / "out", _options(FORMATS[name]), zipped=False)
    for _ in ("with our manifest", "without"):
        for video in videos:
            own = Dataset(GTSRB, (video,))
            compare(own, read_dataset(tmp_path / "out", target_of(own), FORMATS[name]), LOSSES[name])
        # Other tools do not keep our manifest; then only picture names separate two videos of one name.
        (tmp_path / "out" / "manifest.json").unlink(missing_ok=True)


@pytest.mark.parametrize("name", list(FORMATS))
def test_rejected_tracks_are_never_signs(name: str, clip: Path, tmp_path: Path) -> None:
    sign = make_track("m1", [2, 3], boxes=[(5, 6, 25, 30)] * 2, state="accepted")
    wrong = make_track("m2", [3, 9], label=33, boxes=[(40, 20, 60, 40)] * 2, state="rejected", notes=((9, "a lamp"),))
    dataset = Dataset(GTSRB, (_video(clip, [sign, wrong]),))
    out = tmp_path / "out"
    reported = export_dataset(dataset, FORMATS[name], out, _options(FORMATS[name]), zipped=False)
    assert (reported.counts["tracks"], reported.counts["boxes"], reported.counts["negatives"]) == (1, 2, 1)
    assert set(reported.counts["classes"]["default"]) == {"stop"}
    compare(dataset, read_dataset(out, target_of(dataset), FORMATS[name]), LOSSES[name])
    manifest = json.loads((out / "manifest.json").read_text())
    assert [entry["id"] for entry in manifest["videos"][0]["negatives"]] == ["m2"]
    if name == "tracks-json":
        own = json.loads((out / "drive.json").read_text())
        assert ([t["id"] for t in own["tracks"]], [t["id"] for t in own["negatives"]]) == (["m1"], ["m2"])
    (out / "manifest.json").unlink()
    back = read_dataset(out, target_of(dataset), FORMATS[name])
    signs = [track for track in back.videos[0].tracks() if track.state != "rejected"]
    assert {track.label for track in signs} == {14}
    assert sum(len(track.frames) for track in signs) == 2
