"""Settings of all tests, and the options of the campaigns."""

import os
import signal
from collections.abc import Iterator
from typing import NamedTuple

import pytest
from hypothesis import settings

# Most of an export's time is the compiler's optimisation: two FMUs of tests/fmu/conftest.py have it, others do without.
os.environ.setdefault("CFLAGS", "-O0")
settings.register_profile("ropeway", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("ropeway")
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as in a job that a shell runs in the background
    signal.signal(signal.SIGINT, signal.default_int_handler)


class Campaign(NamedTuple):
    """What a campaign of random cases was asked for on the command line."""

    seed: int
    count: int | None

    def size(self, default: int) -> int:
        """Number of cases to try: `default` unless the command line says otherwise."""
        return default if self.count is None else self.count


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declares the options of the campaigns."""
    parser.addoption("--campaign-seed", type=int, default=1, help="seed of the random cases of tests/campaigns")
    parser.addoption("--campaign-count", type=int, default=None, help="number of random cases, instead of a file's own")


@pytest.fixture(scope="session", autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Compiled libraries are kept in a folder of these tests."""
    before = os.environ.get("ROPEWAY_CACHE")
    os.environ["ROPEWAY_CACHE"] = str(tmp_path_factory.mktemp("cache"))
    yield
    if before is None:
        del os.environ["ROPEWAY_CACHE"]
    else:
        os.environ["ROPEWAY_CACHE"] = before


@pytest.fixture
def campaign(request: pytest.FixtureRequest) -> Campaign:
    """Seed and number of random cases: `pytest tests/campaigns -m slow --campaign-seed 7 --campaign-count 1000`."""
    return Campaign(request.config.getoption("--campaign-seed"), request.config.getoption("--campaign-count"))
