import numpy as np
import pytest

from tsr_engine.io.models import component_path, load_component
from tsr_engine.protocols import CropClassifier
from tsr_engine.recognition.classifier import SignClassifier


@pytest.fixture(scope="module")
def shipped() -> SignClassifier:
    return SignClassifier.from_component(load_component("classifier"))


def test_the_shipped_classifier_is_small_and_names_its_training_data() -> None:
    component = load_component("classifier")
    assert component_path("classifier").stat().st_size < 8_000_000
    assert component.data["tracks"] == 1307
    assert component.figures["accuracy"] >= 0.98
    assert component.figures["crops"] == 9990


def test_a_red_disc_with_a_white_bar_is_no_entry(shipped: SignClassifier) -> None:
    y, x = np.mgrid[:60, :60]
    picture = np.full((60, 60, 3), (150, 140, 130), np.uint8)
    picture[np.hypot(x - 29.5, y - 29.5) < 25] = (30, 20, 190)
    picture[26:34, 11:49] = (235, 235, 235)
    classifier: CropClassifier = shipped
    (p,) = classifier.probabilities([picture])
    assert p.argmax() == 17
    assert p.sum() == pytest.approx(1, abs=1e-5)
