"""What a person is told of an error in a method: one line, and where it came from."""

from __future__ import annotations

import re
import traceback

_LONGEST_LINE = 48  # of a headline; what labels and tables have room for
_LONGEST_TRACE = 12_000  # it is sent again whenever the readout changes


def headline(error: BaseException) -> str:
    """The error's kind and the beginning of its message, in one line."""
    try:
        message = " ".join(str(error).split())
    except Exception:  # the user's own error may be as broken
        message = "(its message cannot be shown)"
    line = f"{type(error).__name__}: {message}" if message else type(error).__name__
    return line if len(line) <= _LONGEST_LINE else line[: _LONGEST_LINE - 1] + "…"


def traceback_of(error: BaseException) -> str:
    """The error's traceback as Python prints it, a very long one without its middle.

    The marks under parts of lines are left out, since lines are broken; all but those of a syntax error.
    """
    text = "".join(traceback.format_exception(error))
    if not isinstance(error, SyntaxError):
        text = re.sub(r"^[ ^~]+\n", "", text, flags=re.MULTILINE)
    if len(text) <= _LONGEST_TRACE:
        return text
    half = _LONGEST_TRACE // 2
    return f"{text[:half]}\n…\n{text[-half:]}"
