import pytest

from artipg_dsl.session import Session


@pytest.fixture(scope="session")
def microwave():
    """The sampler of the shipped microwave."""
    return Session.of("Microwave").sampler
