import pytest

from .helpers import Apgc


@pytest.fixture
def apgc(capsys: pytest.CaptureFixture[str]) -> Apgc:
    return Apgc(capsys)
