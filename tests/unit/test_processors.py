"""Threads that a setting stands for."""

from __future__ import annotations

import os

import pytest

from tilesnav_ref.processors import thread_count, usable_processors


def test_zero_is_one_for_each_processor() -> None:
    assert thread_count(0) == usable_processors() >= 1
    assert [thread_count(n) for n in (1, 2, 1000)] == [1, 2, 1000]


def test_systems_that_do_not_say_what_is_usable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 6)
    assert usable_processors() == 6
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert usable_processors() == 1


def test_fewer_than_none_are_refused() -> None:
    with pytest.raises(ValueError, match="threads is -1"):
        thread_count(-1)
