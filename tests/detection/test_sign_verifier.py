"""Sign verifier score and log-odds by hand."""

import numpy as np
import pytest

from tsr_engine.detection.log_odds import LogOdds
from tsr_engine.detection.refine.sign_verifier import SignVerifier
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.recognition.crops import cut
from tsr_engine.training.public.classifier_network import Network, NetworkSettings


def make_verifier(*, common: bool) -> SignVerifier:
    weights = Network(NetworkSettings(filters=3, hidden=8, common=common), 4).weights
    half = {key: value.astype(np.float16) for key, value in weights.items()}
    return SignVerifier.from_arrays({f"likeness_{key}": value for key, value in half.items()})


@pytest.fixture(params=[False, True], ids=["classes", "common"])
def sign_verifier(request: pytest.FixtureRequest) -> SignVerifier:
    return make_verifier(common=request.param)


@pytest.fixture
def picture() -> np.ndarray:
    return np.random.default_rng(0).integers(0, 256, (80, 120, 3), dtype=np.uint8)


BOXES = np.array([[10.0, 20, 40, 50], [-5.0, -5, 20, 20], [100.0, 60, 130, 90]])


def test_without_a_common_machine_the_score_is_the_highest_margin(picture: np.ndarray) -> None:
    sign_verifier = make_verifier(common=False)
    machines: SignClassifier = sign_verifier.machines
    wanted = machines.margins([cut(picture, box, machines.margin) for box in BOXES]).max(axis=1)
    np.testing.assert_array_equal(sign_verifier.scores(picture, BOXES), wanted.astype(np.float64))


def test_a_common_machine_has_half_the_weight(picture: np.ndarray) -> None:
    sign_verifier = make_verifier(common=True)
    machines: SignClassifier = sign_verifier.machines
    assert machines.paired
    features = machines.read([cut(picture, box, machines.margin) for box in BOXES])
    highest = machines.margins_of(features).max(axis=1)
    every = features @ sign_verifier.common[:-1] + sign_verifier.common[-1]
    np.testing.assert_allclose(sign_verifier.scores(picture, BOXES), (highest + every) / 2, rtol=1e-5)
    single = [sign_verifier.scores(picture, box[None])[0] for box in BOXES]
    np.testing.assert_allclose(sign_verifier.scores(picture, BOXES), single, rtol=1e-6)


def test_a_box_outside_the_picture_has_the_lowest_score(sign_verifier: SignVerifier, picture: np.ndarray) -> None:
    boxes = np.array([[200.0, 10, 230, 40], [10.0, -40, 40, 0.5]])
    assert sign_verifier.scores(picture, boxes).tolist() == [-1.0, -1.0]
    assert sign_verifier.scores(picture, np.zeros((0, 4))).shape == (0,)


def test_machines_round_trip_through_arrays(sign_verifier: SignVerifier, picture: np.ndarray) -> None:
    again = SignVerifier.from_arrays(sign_verifier.to_arrays())
    boxes = np.array([[10.0, 20, 40, 50]])
    assert np.array_equal(sign_verifier.scores(picture, boxes), again.scores(picture, boxes))
    with pytest.raises(KeyError, match="likeness_hidden"):
        SignVerifier.from_arrays({k: v for k, v in sign_verifier.to_arrays().items() if k != "likeness_hidden"})
    narrow = sign_verifier.to_arrays() | {"likeness_weights": np.zeros((8, 42), np.float16)}
    with pytest.raises(ValueError, match="43"):
        SignVerifier.from_arrays(narrow)


def test_log_odds_are_the_weighted_sum() -> None:
    odds = LogOdds(0.5, 2.0, 3.0, -1.0)
    verifier, cascade, like = np.array([2.0, 0.0]), np.array([1.0, 0.0]), np.array([-1.0, 0.0])
    assert odds.of(verifier, cascade, like).tolist() == [0.5 * 2 + 2 * 1 - 3 - 1, -1.0]
    scaled = odds.scaled(2.0, 7.0).of(verifier, cascade, like)
    assert scaled.tolist() == (2 * odds.of(verifier, cascade, like) + 7).tolist()
    assert LogOdds(*odds.to_list()) == odds
