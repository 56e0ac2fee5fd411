import pytest

from .texts import Texts


@pytest.fixture
def texts(tmp_path):
    return Texts(tmp_path)
