# SPDX-License-Identifier: BSD-3-Clause
"""Formulas by the KaTeX that reports carry too: Sphinx's MathJax comes over the network, and pages must work without one."""

from html import escape

from docutils.nodes import SkipNode


def _inline(self, node):
    self.body.append(f'<span class="tex">{escape(node.astext())}</span>')
    raise SkipNode


def _display(self, node):
    self.body.append(f'<div class="tex">{escape(_aligned(node.astext()))}</div>')
    raise SkipNode


def _aligned(latex):
    return latex if r"\begin{" in latex or r"\\" not in latex else rf"\begin{{aligned}}{latex}\end{{aligned}}"


def setup(app):
    app.add_html_math_renderer("katex", (_inline, None), (_display, None))
    app.add_css_file("katex.min.css")
    app.add_js_file("katex.min.js", defer="defer")
    app.add_js_file("formulas.js", defer="defer")
    return {"parallel_read_safe": True, "parallel_write_safe": True}
