"""The command as a process of its own: started, heard, interrupted."""

from __future__ import annotations

import codecs
import json
import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from typing import IO, Any

from ._native import Error

# What a script was called with, for the workers that load it.
ARGUMENTS = "TSC_FAMILY_SCRIPT_ARGUMENTS"

# Exit codes with results: some tasks failed, or are left for the next run.
SOME_FAILED = 3
INCOMPLETE = 6
_INTERRUPTED = (75, 130)

# Time that a command has to end after Ctrl-C before it is told again, seconds.
_PATIENCE_S = 2.0

_SAID_LAST = 20_000

# How the line begins in which a command says why it ends.
_ERROR = "error: "


def start() -> list[str]:
    """Returns how the command is started: program and first arguments."""
    if not sys.executable:
        raise Error("Python does not say which program it is (sys.executable), so that no command can be started")
    return [sys.executable, "-m", "tsc_family"]


def call(arguments: Sequence[str], *, show_output: bool, show_progress: bool) -> tuple[int, str, str]:
    """Runs the command; returns its exit code, what it put out, and the last of what it said beside.

    What it says goes on to ``sys.stdout`` and ``sys.stderr`` as it comes, so that notebooks show it too. Ctrl-C ends it
    as it does in a shell, and is raised again.
    """
    child = subprocess.Popen(
        [*start(), *arguments],
        env={**os.environ, ARGUMENTS: json.dumps(sys.argv[1:])},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    output, said = _Heard(child.stdout, sys.stdout, show_output), _Heard(child.stderr, sys.stderr, show_progress)
    try:
        code = child.wait()
    except KeyboardInterrupt:
        _end(child)
        output.end(), said.end()
        raise
    text, words = output.end(), said.end()
    # Whoever cannot go on raises it.
    if code in (0, SOME_FAILED, INCOMPLETE):
        said.release()
    if code in _INTERRUPTED or code == -signal.SIGINT:
        raise KeyboardInterrupt
    return code, text, words


def _end(child: subprocess.Popen[bytes]) -> None:
    """Waits for a command that was interrupted; in a notebook only this process has heard of it."""
    while True:
        try:
            child.wait(_PATIENCE_S)
            return
        except subprocess.TimeoutExpired:
            child.send_signal(signal.SIGINT)
        except KeyboardInterrupt:
            continue


class _Heard:
    """What comes from a pipe, passed on and kept."""

    def __init__(self, pipe: IO[bytes] | None, stream: Any, show: bool) -> None:
        assert pipe is not None
        self._pipe, self._stream, self._show = pipe, stream, show
        self._text = ""
        # What is not passed on yet, whether it begins a line, and whether the error of the command was met.
        self._held, self._begins, self._found = "", True, False
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _listen(self) -> None:
        decode = codecs.getincrementaldecoder("utf-8")("replace")
        while True:
            some = os.read(self._pipe.fileno(), 1 << 16)
            text = decode.decode(some, final=not some)
            self._text = (self._text + text)[-_SAID_LAST:] if self._show else self._text + text
            if self._show:
                self._show_some(text)
            if not some:
                return

    def _show_some(self, text: str) -> None:
        """Passes a text on up to what the command says as its error, which is held back."""
        self._held += text
        if self._found:
            return
        shown, parts = 0, self._held.splitlines(keepends=True)
        for number, part in enumerate(parts):
            begins = self._begins or number > 0
            self._found = begins and part.startswith(_ERROR)
            # The end of a text may be the beginning of an error.
            if self._found or (begins and number + 1 == len(parts) and _ERROR.startswith(part)):
                break
            shown += len(part)
        text, self._held = self._held[:shown], self._held[shown:]
        self._begins = text.endswith(("\n", "\r")) if text else self._begins
        self._write(text)

    def release(self) -> None:
        """Passes on what was held back."""
        text, self._held = self._held, ""
        self._write(text)

    def _write(self, text: str) -> None:
        # A command that nobody hears would wait for ever, so that this goes on whatever becomes of the stream.
        if self._show and text and self._stream is not None:
            try:
                self._pass_on(text)
            except (OSError, ValueError):
                self._stream = None

    def _pass_on(self, text: str) -> None:
        try:
            self._stream.write(text)
        except UnicodeEncodeError:
            self._stream.write(text.encode("ascii", "replace").decode("ascii"))
        self._stream.flush()

    def end(self) -> str:
        self._thread.join()
        self._pipe.close()
        return self._text


def error_of(words: str, code: int) -> Error:
    """Returns the exception with what a command said when it failed."""
    # Where a line begins with it; the message may contain the word too.
    reason = re.split(r"^error: ", words, flags=re.MULTILINE)[-1].strip()
    return Error(reason or f"tsc-family ended with exit code {code} and said nothing")
