"""How much tests do: all of it, for an hour, where BLADESMITH_FULL_BARS=1 is set."""

import os

#: The seeds of every bar are many more where this is set, and cases that others nearly cover are not left out.
FULL = os.environ.get("BLADESMITH_FULL_BARS", "") not in ("", "0")


def seeds(few: int, many: int) -> range:
    """Seeds of random scenes."""
    return range(many if FULL else few)
