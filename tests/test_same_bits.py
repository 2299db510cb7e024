"""A run's results depend on the pixels alone: not on threads, memory alignment, or the BLAS."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tsr_engine
from tests import engine_digests
from tsr_engine.channels.compute import FASTMATH_FLAGS
from tsr_engine.gating.symmetry import MIRROR, SymmetryDetector, similarities
from tsr_engine.linear_algebra import dot, product, solve

ENGINE = Path(tsr_engine.__file__).parent
RUNTIME = ("channels", "detection", "gating", "geometry", "online", "pipeline", "recognition", "tracking")
BY_BLAS = {"dot", "vdot", "inner", "matmul", "einsum", "tensordot", "linalg", "convolve", "correlate"}


@pytest.fixture(scope="module")
def plain() -> dict[str, str]:
    return engine_digests.digests(0, 1)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("by", [0, 1, 3])
def test_threads_and_memory_alignment_change_no_bit(plain: dict[str, str], threads: int, by: int) -> None:
    assert engine_digests.digests(by, threads) == plain


@pytest.mark.slow
@pytest.mark.parametrize("processor", ["Haswell", "Nehalem"])
def test_the_blas_of_another_processor_changes_no_bit(plain: dict[str, str], processor: str) -> None:
    """With these kernels, a product of 64 rows differs in the last bits between one and two threads."""
    environment = {**os.environ, "OPENBLAS_CORETYPE": processor}
    command = [sys.executable, "-m", "tests.engine_digests"]
    result = subprocess.run(
        command, env=environment, cwd=Path(__file__).parents[1], capture_output=True, text=True, check=True, timeout=240
    )
    assert json.loads(result.stdout) == [plain, plain]


def test_nothing_between_pixels_and_records_multiplies_by_blas() -> None:
    found = []
    for path in sorted(path for package in RUNTIME for path in (ENGINE / package).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            by_blas = isinstance(node, ast.Attribute) and node.attr in BY_BLAS and getattr(node.value, "id", "") == "np"
            if by_blas or (isinstance(node, (ast.BinOp, ast.AugAssign)) and isinstance(node.op, ast.MatMult)):
                found.append(f"{path.relative_to(ENGINE)}:{node.lineno}")  # type: ignore[attr-defined]
    assert found == []


def test_no_kernel_of_the_channels_reorders_or_fuses_sums() -> None:
    """With ``reassoc`` or ``contract``, compiled code and code from the cache differ in the last bits."""
    flags = {
        ast.unparse(keyword.value)
        for path in (ENGINE / "channels").rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call)
        for keyword in node.keywords
        if keyword.arg == "fastmath"
    }
    assert flags == {"FASTMATH_FLAGS"}
    assert {"nnan", "ninf", "nsz"} == FASTMATH_FLAGS


@given(st.integers(0, 9), st.integers(0, 11), st.integers(0, 9), st.sampled_from([np.float32, np.float64]))
def test_a_product_sums_its_terms_in_order(n: int, k: int, m: int, kind: type) -> None:
    rng = np.random.default_rng(n * 100 + k * 10 + m)
    a, b = rng.normal(size=(n, k)).astype(kind), rng.normal(size=(k, m)).astype(kind)
    expected = np.zeros((n, m), kind)
    for term in range(k):
        expected = expected + a[:, term : term + 1] * b[term]
    for again in (b, np.asfortranarray(b)):
        found = product(a, again)
        assert found.dtype == kind
        assert found.tobytes() == expected.tobytes()
    np.testing.assert_allclose(expected, a @ b, rtol=1e-4, atol=1e-4)
    if kind is np.float64 and n and m:
        assert dot(a[0], np.ascontiguousarray(b[:, 0])) == expected[0, 0]


@given(st.integers(1, 9), st.integers(1, 4))
def test_a_system_is_solved_like_lapack(n: int, m: int) -> None:
    rng = np.random.default_rng(n * 10 + m)
    a, b = rng.normal(size=(n, n)), rng.normal(size=(n, m))
    a[0, 0] = 0.0 if n > 1 else a[0, 0]
    before = a.copy(), b.copy()
    np.testing.assert_allclose(solve(a, b), np.linalg.solve(a, b), rtol=1e-8, atol=1e-9)
    assert (a == before[0]).all()
    assert (b == before[1]).all()


def test_a_singular_system_is_refused() -> None:
    with pytest.raises(np.linalg.LinAlgError, match="singular"):
        solve(np.array([[1.0, 2.0], [2.0, 4.0]]), np.ones((2, 1)))


def test_sift_is_integral_and_similarity_is_the_cosine_of_the_mirror_image() -> None:
    picture = cv2.GaussianBlur(np.random.default_rng(2).integers(0, 256, (48, 48), dtype=np.uint8), (0, 0), 2.0)
    plain = cv2.SIFT.create(nfeatures=80, nOctaveLayers=3, contrastThreshold=0.003)
    expected = plain.detectAndCompute(picture, None)[1]
    descriptors = SymmetryDetector().sift.detectAndCompute(picture, None)[1]
    assert len(descriptors) > 20
    assert descriptors.dtype == np.uint8
    assert (descriptors == expected).all()
    unit = descriptors / np.linalg.norm(descriptors.astype(np.float64), axis=1, keepdims=True)
    cosine = unit @ unit[:, MIRROR].T
    found = similarities(descriptors)
    np.testing.assert_allclose(found, np.clip((cosine - 0.6) / 0.3, 0.0, 1.0), atol=1e-14)
    assert (found == found.T).all()
    assert similarities(np.zeros((2, 128), np.uint8)).tolist() == [[0.0, 0.0], [0.0, 0.0]]
