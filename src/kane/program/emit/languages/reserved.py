# SPDX-License-Identifier: BSD-3-Clause
"""Reserved words of languages, and names that emitted text uses."""

from collections.abc import Iterable

from kane.program.emit.identifiers import IsFree, is_free_in_python

_WORDS = {
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


def free_in(language: str) -> IsFree:
    """The test that a name is not reserved in a language; names that begin with kane_ are reserved for the emitted file."""
    words = {*_WORDS[language].split(), *(f"kane_{name}" for name in _HELPERS.split())}
    return lambda name: name not in words


def free_in_module(*own: str) -> IsFree:
    """The same test for Python modules that import or define the names `own`."""
    words: Iterable[str] = frozenset(own)
    return lambda name: is_free_in_python(name) and name not in words and not name.startswith("_")


_HELPERS = "sqrt log asin acos pow min max sign where regular sin cos tan sincos abs atan atan2 sinh cosh tanh exp floor less hoist"
