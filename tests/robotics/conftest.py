"""Fixtures of the tests of robots."""

import pytest

from robotics.simulation.loop import simulate


def _fails(*arguments, **options):
    raise AssertionError("a run was driven")


@pytest.fixture
def no_runs(monkeypatch):
    """Let every run fail."""
    # In place, so that whoever has imported it, or does so now, has the same function, now and after this test.
    monkeypatch.setattr(simulate, "__code__", _fails.__code__)
