"""A signal ends a command, also where Python cannot pass its exception on."""

from __future__ import annotations

import ctypes
import signal
import sys
import threading

import pytest

from tilesnav_ref.commands.signals import NUMBERS, Stopped, stop_on_signals


@pytest.mark.parametrize("number", NUMBERS)
def test_a_signal_raises_at_once(number: signal.Signals) -> None:
    with stop_on_signals() as request:
        request.check()
        with pytest.raises(Stopped) as stop:
            signal.raise_signal(number)
    assert stop.value.number == number


@pytest.mark.parametrize("number", NUMBERS)
def test_a_signal_in_a_callback_of_c_code_is_remembered(
    number: signal.Signals, capfd: pytest.CaptureFixture[str]
) -> None:
    callback = ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(number))
    with stop_on_signals() as request:
        callback()
        with pytest.raises(Stopped) as stop:
            request.check()
    assert stop.value.number == number
    assert capfd.readouterr() == ("", "")


def test_other_lost_exceptions_are_still_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[type[BaseException] | None] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda lost: seen.append(lost.exc_type))
    callback = ctypes.CFUNCTYPE(None)(lambda: {}[0])
    with stop_on_signals():
        callback()
    assert seen == [KeyError]


def test_what_was_set_is_put_back() -> None:
    before = [*map(signal.getsignal, NUMBERS), sys.unraisablehook]
    with stop_on_signals():
        assert all(now != then for now, then in zip(map(signal.getsignal, NUMBERS), before, strict=False))
    assert [*map(signal.getsignal, NUMBERS), sys.unraisablehook] == before


def test_another_thread_cannot_ask_for_signals_and_goes_on() -> None:
    before = [*map(signal.getsignal, NUMBERS)]
    seen: list[object] = []

    def work() -> None:
        with stop_on_signals() as request:
            request.check()
            seen.append(signal.getsignal(signal.SIGTERM))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [before[1]]
