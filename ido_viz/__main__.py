"""The command `ido-viz`: its parts take seconds to load, and Ctrl-C meanwhile ends it as quietly as later."""

from __future__ import annotations

import sys

INTERRUPTED = 130
"""What shells expect of a command that Ctrl-C ended."""


def main() -> int:
    """Run the explorer until Ctrl-C."""
    try:
        from ido_viz.command import run

        return run()
    except KeyboardInterrupt:
        return INTERRUPTED
    except ImportError as error:
        if isinstance(error.__cause__, KeyboardInterrupt):  # what compiled modules make of Ctrl-C while they are loaded
            return INTERRUPTED
        raise


if __name__ == "__main__":
    sys.exit(main())
