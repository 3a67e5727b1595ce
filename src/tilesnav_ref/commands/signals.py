"""SIGINT and SIGTERM unwind the stack, so that folders that are being made are removed on the way out."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

NUMBERS = (signal.SIGINT, signal.SIGTERM)


class Stopped(BaseException):
    """The process was asked to end by the signal `number`."""

    def __init__(self, number: signal.Signals) -> None:
        super().__init__(number.name)
        self.number = number


class StopRequest:
    """The signal that asked for the end, if any.

    A handler's exception is lost where Python code is called from C code that cannot pass it on (a callback
    of the compiler of kernels, a finaliser). So the request is also remembered, and long work asks for it.
    """

    def __init__(self) -> None:
        self._number: signal.Signals | None = None

    def check(self) -> None:
        """Raise `Stopped` when a signal has come."""
        if self._number is not None:
            raise Stopped(self._number)

    def receive(self, number: int, _frame: FrameType | None = None) -> None:
        """Remember a signal and raise; made to be a signal handler."""
        self._number = signal.Signals(number)
        self.check()


@contextmanager
def stop_on_signals() -> Iterator[StopRequest]:
    """Raise `Stopped` on SIGINT and SIGTERM. Only the main thread may ask for that; others just go on."""
    request = StopRequest()
    if threading.current_thread() is not threading.main_thread():
        yield request
        return
    handlers = [signal.signal(number, request.receive) for number in NUMBERS]
    hook = sys.unraisablehook
    sys.unraisablehook = lambda lost: None if isinstance(lost.exc_value, Stopped) else hook(lost)
    try:
        yield request
    finally:
        sys.unraisablehook = hook
        for number, handler in zip(NUMBERS, handlers, strict=True):
            signal.signal(number, handler)
