"""The command `ido-viz`: its parts take seconds to load, and Ctrl-C meanwhile ends it as quietly as later."""

from __future__ import annotations

import signal
import sys

INTERRUPTED = 130
"""What shells expect of a command that Ctrl-C ended."""


def main() -> int:
    """Run the explorer until Ctrl-C."""
    ends_it = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if ends_it:  # as an exception, modules that are being loaded would make other errors of it, with tracebacks
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from ido_viz.command import run

    if ends_it:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return run()
    except KeyboardInterrupt:
        return INTERRUPTED
    except ImportError as error:
        if isinstance(error.__cause__, KeyboardInterrupt):  # what some make of it that are loaded when they are used
            return INTERRUPTED
        raise


if __name__ == "__main__":
    sys.exit(main())
