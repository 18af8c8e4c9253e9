# SPDX-License-Identifier: BSD-3-Clause
"""Text and formulas as LaTeX in ASCII, for pdflatex with its default fonts."""

import re
import unicodedata

from kane.present.pages import segments

_SPECIAL = {c: "\\" + c for c in "#$%&{}_"} | {
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": "$<$", ">": "$>$", "|": "$|$", '"': "''",
}  # fmt: skip
_SIGNS = {
    "−": "-", "×": r"\times ", "÷": r"\div ", "√": r"\surd ", "≤": r"\le ", "≥": r"\ge ", "≠": r"\ne ", "→": r"\to ", "∫": r"\int ",
    "·": r"\cdot ", "⋅": r"\cdot ", "°": r"^{\circ}", "∂": r"\partial ", "∞": r"\infty ", "≈": r"\approx ", "±": r"\pm ", "∈": r"\in ",
    "○": r"\circ ",
    "●": r"\bullet ", "•": r"\bullet ", "′": "'", "∑": r"\sum ", "∆": r"\Delta ", "↦": r"\mapsto ", "‖": r"\| ",
}  # fmt: skip
"""Commands in formulas."""
_WRITTEN = {
    "–": "--", "—": "---", "…": r"\dots{}", "‘": "`", "’": "'", "“": "``", "”": "''", "„": ",,", "\u00a0": "~", "ß": r"\ss{}",
    "æ": r"\ae{}", "Æ": r"\AE{}", "ø": r"\o{}", "Ø": r"\O{}", "å": r"\aa{}", "Å": r"\AA{}", "ł": r"\l{}", "Ł": r"\L{}", "œ": r"\oe{}",
    "§": r"\S{}", "ı": r"\i{}", "\u200b": "",
}  # fmt: skip
"""Commands in text."""
_ACCENTS = {
    "\u0300": "`", "\u0301": "'", "\u0302": "^", "\u0303": "~", "\u0304": "=", "\u0306": "u", "\u0307": ".",
    "\u0308": '"', "\u030a": "r", "\u030b": "H", "\u030c": "v", "\u0327": "c",
}  # fmt: skip
_RAISED = {"<super>": "^", "<sub>": "_"}
_CAPITALS = {"Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi", "Omega"}
_BEYOND = re.compile(r"[^\x00-\x7f]")


def text_latex(plain: str) -> str:
    """Plain text as LaTeX."""
    letters: list[str] = []
    for c in _marked(plain):
        if c in _ACCENTS and letters:
            letters.append(rf"\{_ACCENTS[c]}{{{letters.pop()}}}")
        else:
            letters.append(_SPECIAL.get(c) or _WRITTEN.get(c) or (c if c < "\x7f" else _written(c)))
    return "".join(letters).replace("$$", "")


def prose(sentence: str) -> str:
    """Text with formulas between dollar signs as LaTeX."""
    return "".join(f"${math_latex(piece)}$" if formula else text_latex(piece) for formula, piece in segments(sentence))


def math_latex(latex: str) -> str:
    """A formula as LaTeX in ASCII."""
    return _BEYOND.sub(lambda m: _sign(m[0]) or rf"\text{{{text_latex(m[0])}}}", latex)


def _marked(plain: str) -> str:
    """Text with accents separated from their letters, except letters with their own command."""
    return "".join(c if c in _WRITTEN else unicodedata.normalize("NFD", c) for c in plain)


def _written(c: str) -> str:
    sign = _sign(c)
    plain = unicodedata.normalize("NFKD", c).replace("\u2044", "/").encode("ascii", "ignore").decode()
    return f"${sign}$" if sign else plain or f"[U+{ord(c):04X}]"


def _sign(c: str) -> str:
    """LaTeX of a sign, a Greek letter, a superscript or subscript character; "" for others."""
    if c in _SIGNS:
        return _SIGNS[c]
    kind, _, code = unicodedata.decomposition(c).partition(" ")
    if kind in _RAISED:
        return f"{_RAISED[kind]}{{{math_latex(''.join(chr(int(x, 16)) for x in code.split()))}}}"
    greek = re.fullmatch(r"GREEK (SMALL|CAPITAL) LETTER (\w+)", unicodedata.name(c, ""))
    if greek is None:
        return ""
    name = greek[2].lower().replace("lamda", "lambda")
    if greek[1] == "CAPITAL":
        return rf"\{name.title()} " if name.title() in _CAPITALS else rf"\mathrm{{{name[0].upper()}}}"
    return "o" if name == "omicron" else r"\varsigma " if name == "final" else rf"\{name} "
