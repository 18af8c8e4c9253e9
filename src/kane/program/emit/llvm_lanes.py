# SPDX-License-Identifier: BSD-3-Clause
"""Doubles side by side, as LLVM writes them: the width of vectors is a parameter of every template."""

import struct
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Lanes:
    """`width` doubles: a vector, or for one a plain double."""

    width: int

    def of(self, kind: str) -> str:
        """The type of `width` values of a kind."""
        return f"<{self.width} x {kind}>" if self.width > 1 else kind

    @property
    def double(self) -> str:
        """The type of the numbers."""
        return self.of("double")

    @property
    def suffix(self) -> str:
        """What the names of LLVM's functions for them end in."""
        return f"v{self.width}f64" if self.width > 1 else "f64"

    def all(self, kind: str, value: object) -> str:
        """A constant with one value in every lane."""
        return f"splat ({kind} {value})" if self.width > 1 else str(value)

    def number(self, value: float) -> str:
        """A number in every lane."""
        return self.all("double", bits(value))

    def padded(self, count: int) -> int:
        """`count` doubles rounded up to whole vectors."""
        return -(-count // self.width) * self.width


def bits(value: float) -> str:
    """A double as LLVM reads it, exactly."""
    return f"0x{struct.pack('>d', value).hex().upper()}"
