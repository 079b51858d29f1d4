"""How C, C++ and GLSL write what elementary functions need of the machine: see templates/export/machine.j2."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Notation:
    """Types and names of one language in one precision.

    Attributes
    ----------
    bits : int
        Of a number: 64 or 32.
    real, word, unsigned : str
        Types: of numbers, and of integers of as many bits with a sign and without.
    boolean, wide, wide_unsigned : str
        Types: of conditions, and of the largest integers with a sign and without.
    inline, integer_inline : str
        What stands before a function of numbers, and before one of integers, with a space behind it, or nothing.
    prefix, name : str
        What names of elementary functions and of other functions begin with.
    suffix : str
        Of numbers.
    constant, table : str
        Before a number that does not change, and before an array of such.
    result, place, argument : str
        Before the name of one of several results: as a parameter, inside, and where the function is called.
    is_functional : bool
        Types are called like functions: ``int(x)``.
    """

    bits: int
    real: str
    word: str
    unsigned: str
    boolean: str
    wide: str
    wide_unsigned: str
    inline: str
    integer_inline: str
    prefix: str = ""
    name: str = ""
    suffix: str = ""
    constant: str = "const "
    table: str = "static const"
    result: str = "*"
    place: str = "*"
    argument: str = "&"
    is_functional: bool = False

    def to(self, type: str) -> str:
        """Before a number in brackets: makes it one of this type."""
        return type if self.is_functional else f"({type})"

    @property
    def mantissa(self) -> int:
        """Bits stored of a significand."""
        return 52 if self.bits == 64 else 23

    @property
    def bias(self) -> int:
        """Of an exponent."""
        return 1023 if self.bits == 64 else 127

    @property
    def one(self) -> str:
        """Bits of 1."""
        return "0x3ff0000000000000u" if self.bits == 64 else "0x3f800000u"

    @property
    def root_half(self) -> str:
        """Bits of the square root of 1/2."""
        return "0x3fe6a09e667f3bcdu" if self.bits == 64 else "0x3f3504f3u"

    @property
    def mantissa_mask(self) -> str:
        return "0x000fffffffffffffu" if self.bits == 64 else "0x007fffffu"

    @property
    def magnitude_mask(self) -> str:
        """All bits but the sign's."""
        return "0x7fffffffffffffffu" if self.bits == 64 else "0x7fffffffu"

    @property
    def smallest(self) -> str:
        """The smallest normal number."""
        return f"{2.2250738585072014e-308 if self.bits == 64 else 1.1754943508222875e-38!r}{self.suffix}"

    @property
    def small_scale(self) -> str:
        """The power of two by which subnormal numbers are scaled: two bits more than a significand."""
        return f"{2.0 ** (self.mantissa + 2)!r}{self.suffix}"

    @property
    def shifter(self) -> str:
        """The number that an integer is added to, to stand in the lowest bits."""
        return f"{1.5 * 2.0**self.mantissa!r}{self.suffix}"

    @property
    def epsilon(self) -> str:
        """The distance from 1 to the next number."""
        return f"{2.0**-self.mantissa!r}{self.suffix}"

    @property
    def largest(self) -> str:
        """The largest finite number."""
        return f"{1.7976931348623157e308 if self.bits == 64 else 3.4028234663852886e38!r}{self.suffix}"
