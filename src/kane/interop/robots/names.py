# SPDX-License-Identifier: BSD-3-Clause
"""Names of a source as identifiers, each once: what is none is renamed, and that is said."""

import keyword
from collections.abc import Mapping

from kane.errors import cut
from kane.interop.imported import Remark
from kane.program.emit.names import numbered, word

LONGEST = 80


class Names:
    """Identifiers that are given out so far; the remarks tell which names changed."""

    def __init__(self) -> None:
        self.taken: set[str] = set()
        self.remarks: list[Remark] = []

    def identifier(self, name: str, what: str, where: str = "") -> str:
        """An identifier for the thing `what` of this name, of its own."""
        plain = word(name[:LONGEST], what)
        found = numbered(f"{what}_{plain}" if keyword.iskeyword(plain) else plain, self.taken)
        if found != name:
            self.remarks.append(Remark("inferred", f"{what} {cut(name)!r} is called {found}", where))
        return found


def table(names: Names, things: Mapping[str, str], what: str) -> dict[str, str]:
    """Identifiers by the names of things, which map to where they stand."""
    return {name: names.identifier(name, what, where) for name, where in things.items()}
