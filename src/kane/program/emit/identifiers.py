# SPDX-License-Identifier: BSD-3-Clause
"""Names and texts of models as identifiers, string literals and comments of C and Python.

Names and descriptions may contain any characters; the functions here escape those that would end a literal or a comment.
"""

import keyword
import math
import re
import unicodedata
from collections import Counter
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass

from kane.program.emit.walk import VECTORS, Function
from kane.program.program import Program

_WORDS = """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t char8_t class co_await
    co_return co_yield compl concept const const_cast consteval constexpr constinit continue decltype default delete do
    double dynamic_cast else enum explicit export extern false float for fortran friend goto if inline int long mutable
    namespace new noexcept not not_eq nullptr operator or or_eq private protected public register reinterpret_cast
    requires restrict return short signed sizeof static static_assert static_cast struct switch template this
    thread_local throw true try typedef typeid typename typeof typeof_unqual union unsigned using virtual void volatile
    wchar_t while xor xor_eq
"""
_FUNCTIONS = """
    acos acosh acospi asin asinh asinpi atan atan2 atan2pi atanh atanpi canonicalize cbrt ceil compoundn copysign cos
    cosh cospi drem erf erfc exp exp10 exp10m1 exp2 exp2m1 expm1 fabs fadd fdim fdiv ffma finite floor fma fmax fmaximum
    fmaximum_mag fmaximum_mag_num fmaximum_num fmaxmag fmin fminimum fminimum_mag fminimum_mag_num fminimum_num fminmag
    fmod fmul frexp fromfp fromfpx fsqrt fsub gamma getpayload hypot ilogb isinf isnan j0 j1 jn ldexp lgamma llogb
    llrint llround log log10 log10p1 log1p log2 log2p1 logb logp1 lrint lround modf nan nearbyint nextafter nextdown
    nexttoward nextup pow pown powr remainder remquo rint rootn round roundeven rsqrt scalb scalbln scalbn setpayload
    setpayloadsig significand sin sincos sinh sinpi sqrt tan tanh tanpi tgamma totalorder totalordermag trunc ufromfp
    ufromfpx y0 y1 yn
"""
_OTHERS = """
    abs complex daddl ddivl dfmal dmull double_t dsqrtl dsubl exception float_t fpclassify imaginary iscanonical iseqsig
    isfinite isgreater isgreaterequal isless islessequal islessgreater isnormal issignaling issubnormal isunordered
    iszero kane_cos kane_sin kane_sincos main matherr math_errhandling signbit signgam size_t
    arm far hpux huge i386 interface linux m68k max min mips near ppc sgi small sparc sun unix vax
    DECIMAL_DIG DOMAIN EOF HUGE I INFINITY KANE_PART MAXFLOAT NAN NULL OVERFLOW PLOSS SING SNAN TLOSS UNDERFLOW X_TLOSS
"""
_KINDS = ("", "f", "l", "f16", "f32", "f64", "f128", "f32x", "f64x", "f128x")
_RESERVED_C = frozenset(
    [*_WORDS.split(), *_OTHERS.split(), *(f + k for f in _FUNCTIONS.split() for k in _KINDS)]
    + [f"lgamma{k}_r" for k in _KINDS]
)
_FAMILIES_C = re.compile(
    r"(?:u?int|size|ptrdiff|wchar|char)\w*_t|(?:FP|FLT|DBL|LDBL|DEC\d*|MATH|HUGE_VAL|SIZE|PTRDIFF|SIG_ATOMIC|WCHAR|WINT)_\w+"
    r"|U?INT(?:_|\d|MAX|PTR)\w*|M_(?:1|2|E|LN|LOG|PI|SQRT)\w*|(?:SNAN|HUGE_VAL)(?:[FL]|F\d+X?)?|f\d+x?(?:add|sub|mul|div|fma|sqrt)f\d+x?"
)
_RESERVED_PYTHON = frozenset([*keyword.kwlist, *keyword.softkwlist, "np", "float", "len", "ValueError"])

_RESERVED = {
    "matlab": (
        "break case catch classdef continue do else elseif end end_try_catch end_unwind_protect endfor endfunction endif "
        "endparfor endproperties endswitch endwhile enumeration events for function global if methods otherwise parfor "
        "persistent properties return spmd switch try until unwind_protect unwind_protect_cleanup while "
        "NaN Inf nan inf i j pi e eps ans NA abs sqrt sin cos tan asin acos atan atan2 sinh cosh tanh exp log sign floor "
        "double zeros min max isinf system model varargin nargin size numel reshape struct"
    ),
    "julia": (
        "abstract baremodule begin break catch const continue do else elseif end export false finally for function global "
        "if import importall in isa let local macro module mutable new outer primitive public quote return struct true try "
        "type using where while Base Core Main NaN Inf pi im nothing missing abs sqrt sin cos tan asin acos atan sinh cosh "
        "tanh exp log sign floor ifelse oftype isnan isinf isinteger eval include promote_type eltype length vec "
        "Float64 NTuple Vector Any zero one error"
    ),
    "modelica": (
        "algorithm and annotation assert block break class connect connector constant constrainedby der discrete each else "
        "elseif elsewhen encapsulated end enumeration equation expandable extends external false final flow for function "
        "if import impure in initial inner input loop model not operator or outer output package parameter partial "
        "protected public pure record redeclare replaceable return stream then true type when while within time "
        "Real Integer Boolean String abs sqrt sin cos tan asin acos atan atan2 sinh cosh tanh exp log sign floor min max "
        "mod div rem ceil integer size fill zeros ones array scalar vector matrix transpose sum product noEvent smooth pre "
        "edge change reinit sample terminate terminal delay homotopy Modelica Motion"
    ),
    "javascript": (
        "abstract arguments await boolean break byte case catch char class const continue debugger default delete do double "
        "else enum eval export extends false final finally float for function goto if implements import in instanceof int "
        "interface let long native new null of package private protected public return short static super switch "
        "synchronized this throw throws transient true try typeof undefined var void volatile while with yield async get "
        "set Math NaN Infinity Array Float64Array Number Object globalThis"
    ),
    "rust": (
        "abstract as async await become box break const continue crate do dyn else enum extern false final fn for gen if "
        "impl in let loop macro match mod move mut override priv pub raw ref return safe self Self static struct super "
        "trait true try type typeof union unsafe unsized use virtual where while yield "
        "f64 f32 u8 u16 u32 u64 u128 usize i8 i16 i32 i64 i128 isize bool char str core std alloc None Some Ok Err Option Result "
        "NAN INFINITY math "
        "abs sqrt sin cos tan asin acos atan atan2 sinh cosh tanh exp log pow sign floor main test"
    ),
}
_HELPERS = "sqrt log asin acos pow min max sign where regular sin cos tan sincos abs atan atan2 sinh cosh tanh exp floor less hoist"

ARITHMETIC = {"add": "{0} + {1}", "sub": "{0} - {1}", "mul": "{0} * {1}", "div": "{0} / {1}", "neg": "-{0}"}
"""Operations with the same syntax in C and Python."""

LONGEST_NAME = 63
"""The number of significant characters of an identifier in C99; MATLAB truncates longer ones."""

IsFree = Callable[[str], bool]


def is_free_in_c(name: str) -> bool:
    """Whether `name` is neither reserved in C or C++ nor declared in their mathematical headers."""
    return name not in _RESERVED_C and not _FAMILIES_C.fullmatch(name)


def is_free_in_python(name: str) -> bool:
    """Whether `name` is neither reserved in Python nor used by the fixed lines of an emitted module."""
    return name not in _RESERVED_PYTHON


def free_in(language: str) -> IsFree:
    """The test that a name is not reserved in a language; names that begin with kane_ are reserved for the emitted file."""
    words = {*_RESERVED[language].split(), *(f"kane_{name}" for name in _HELPERS.split())}
    return lambda name: name not in words


def free_in_module(*own: str) -> IsFree:
    """The same test for Python modules that import or define the names `own`."""
    words: Iterable[str] = frozenset(own)
    return lambda name: is_free_in_python(name) and name not in words and not name.startswith("_")


def identifier(text: str) -> str:
    """`text` in ASCII letters, digits and single underscores: "θ₁'" → "theta1"; "" if the result would not begin with a letter."""
    name = re.sub(r"[^A-Za-z0-9]+", "_", "".join(map(_ascii, unicodedata.normalize("NFKC", text)))).strip("_")
    return name if name[:1].isalpha() else ""


def word(text: str, what: str) -> str:
    """`text` if it is an ASCII identifier, else converted to one, with the prefix `what` if it would not begin with a letter."""
    return text if text.isascii() and text.isidentifier() else identifier(text) or identifier(f"{what}_{text}")


def _ascii(c: str) -> str:
    greek = re.match(r"GREEK (SMALL|CAPITAL) LETTER (\w+)", unicodedata.name(c, ""))
    if greek:
        return greek[2].lower() if greek[1] == "SMALL" else greek[2].title()
    return c if c.isascii() else "_"


@dataclass(frozen=True, slots=True)
class Names:
    """The identifiers of a program in one language: `arguments`, one for each port or vector, and `inputs`."""

    program: Program
    arguments: dict[str, str]
    inputs: tuple[str, ...]

    def of(self, function: Function, number: Callable[[float], str]) -> dict[int, str]:
        """The identifier of each value of a function: h3 for hoisted values, z12 for computed values, a literal for constants."""
        taken = (*self.inputs, *self.arguments.values())
        h, z = stem("h", taken), stem("z", taken)
        names = dict(enumerate((*self.inputs, *map(number, self.program.constants))))
        names.update({i: f"{h}{k}" for k, i in enumerate(function.kept)})
        names.update({i: f"{z}{k}" for k, i in enumerate(function.block, 1)})
        return names


def local_names(program: Program, is_free: IsFree) -> Names:
    """Names of arguments and inputs: an input's name if it is a short and unique identifier, else the port and an index: x0, p3."""
    ports = distinct([port.name for port in program.ports], is_free, VECTORS.values())
    arguments = dict(zip((port.name for port in program.ports), ports, strict=True)) | VECTORS
    names = [identifier(s.name) for s in program.inputs]
    times, reserved = Counter(names), set(arguments.values())
    own = {n for n in names if n and times[n] == 1 and n not in reserved and len(n) <= LONGEST_NAME and is_free(n)}
    inputs: list[str] = []
    taken = {*own, *reserved}
    for port in program.ports:
        base = stem(arguments[port.name] + "_" * port.name[-1].isdigit(), taken)
        taken.add(f"{base}0")
        for k in range(len(port.symbols)):
            name = names[len(inputs)]
            inputs.append(arguments[port.name] if port.scalar else name if name in own else f"{base}{k}")
    return Names(program, arguments, tuple(inputs))


def stem(base: str, taken: Iterable[str]) -> str:
    """`base`, with its last letter repeated until no taken name consists of it and a number."""
    numbered = {n.rstrip("0123456789") for n in taken if n[-1:].isdigit()}
    while base in numbered:
        base += base[-1]
    return base


def distinct(bases: Iterable[str], is_free: IsFree, taken: Collection[str] = ()) -> list[str]:
    """Distinct names: `bases` with the prefix "kane_" where they are not free, and a number appended to repeated ones."""
    used = set(taken)
    names = []
    for base in bases:
        while not is_free(base):
            base = f"kane_{base}"
        names.append(numbered(base, used))
    return names


def numbered(base: str, used: set[str]) -> str:
    """`base`, with a number appended if it is already used; adds the result to `used`."""
    name, k = base, 2
    while name in used:
        name, k = f"{base}_{k}", k + 1
    used.add(name)
    return name


def made_by(version: str) -> str:
    """The note that names kane and its version as the source of the text."""
    return f"Made by kane{' ' if version else ''}{version}: derive and emit again instead of editing."


def decimal(value: float, nan: str, infinity: str) -> str:
    """The shortest decimal literal that reads back as exactly `value`, or the text of NaN or infinity."""
    if math.isfinite(value):
        return repr(value) if math.copysign(1.0, value) > 0 else f"({value!r})"
    return nan if math.isnan(value) else infinity if value > 0 else f"(-{infinity})"


def c_number(value: float) -> str:
    """A C expression of exactly `value`."""
    return decimal(value, "NAN", "INFINITY")


def c_string(text: str) -> str:
    """A C string literal in UTF-8; nonprinting characters and the second ? of a trigraph are escaped."""
    escaped = "".join(_C_ESCAPES.get(c) or (c if c.isprintable() else _octal(c)) for c in text)
    return '"' + re.sub(r"(?<=\?)\?", r"\?", escaped) + '"'


_C_ESCAPES = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t"}


def _octal(c: str) -> str:
    return "".join(f"\\{byte:03o}" for byte in c.encode("utf-8", "replace"))


def c_comment(text: str) -> str:
    """`text` as one line that neither ends a C comment nor continues it on the next line."""
    line = "".join(c if c.isprintable() else " " for c in text).replace("\\", "∖")
    return re.sub(r"(?<=[*/?])(?=[*/?])", " ", line)


def python_comment(text: str) -> str:
    """`text` as one line of printing characters."""
    return repr(text)[1:-1].replace("\\\\", "\\")


def python_docstring(text: str) -> str:
    """A docstring literal whose value is `text`."""
    body = "".join(c if c == "\n" or (c.isprintable() and c != "\\") else repr(c)[1:-1] for c in text)
    return '"""' + re.sub(r'"(?="|\Z)', r"\"", body) + '"""'
