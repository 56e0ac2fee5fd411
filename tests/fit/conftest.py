import pytest

import artipg_dsl as apg
from artipg_dsl.fit.model import Model

from .helpers import BOARD, TEXT, N


@pytest.fixture(scope="session")
def samples() -> apg.Samples:
    return apg.load(TEXT, n=N, seed=5)


@pytest.fixture(scope="session")
def model(samples: apg.Samples) -> Model:
    return Model(samples.job.sampler)


@pytest.fixture(scope="session")
def boards() -> apg.Samples:
    return apg.load(BOARD, n=12, seed=1)
