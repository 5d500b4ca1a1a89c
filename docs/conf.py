"""The documentation site: `python -m sphinx -W -b html docs build/site`.

The API reference is made from the docstrings of all public names, which the stubs `__init__.pyi` list. Formulas become
MathML: a page needs neither a network nor a script.
"""

from __future__ import annotations

import sys
from pathlib import Path

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from numpydoc.xref import DEFAULT_LINKS
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.ext.autosummary import autosummary_toc
from sphinx.writers.html5 import HTML5Translator

import ropeway

sys.path.insert(0, str(Path(__file__).parent))
import gallery

project = "ropeway"
author = "the authors of ropeway"
release = version = ropeway.__version__

extensions = ["myst_parser", "numpydoc", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx_design"]
exclude_patterns = ["_templates"]
templates_path = ["_templates"]

myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3

html_theme = "furo"
html_title = f"ropeway {release}"
html_math_renderer = "mathml"
html_show_copyright = False
html_show_sourcelink = False
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False

autosummary_imported_members = True
autosummary_ignore_module_all = False
autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_xref_param_type = True
numpydoc_xref_ignore = "all"  # but the aliases below

PUBLIC = {
    **{f"rw.{name}": f"ropeway.{name}" for name in ropeway.__all__},
    **{f"rw.fmu.{name}": f"ropeway.fmu.{name}" for name in ropeway.fmu.__all__},
}
"""Public names as the documents write them, and their full names."""

numpydoc_xref_aliases = {
    **{word: word for word in DEFAULT_LINKS},  # no links to documents of others, which need a network
    **{name.rpartition(".")[2]: full for name, full in PUBLIC.items() if name.rpartition(".")[2][0].isupper()},
}
"""Types of parameters and results that become links."""


def run_scripts(app: Sphinx) -> None:
    """Makes the gallery and all pictures that scripts make."""
    gallery.make()


def link_public_names(app: Sphinx, doctree: nodes.document) -> None:
    """Links public names in the documents to their pages; without `rw.` only in the list of names."""
    document = app.env.current_document.docname
    if document.startswith("api/"):
        return
    for literal in list(doctree.findall(nodes.literal)):
        written = literal.astext().removesuffix("()")
        name = PUBLIC.get(written) or (PUBLIC.get(f"rw.{written}") if document == "names" else None)
        if name and not isinstance(literal.parent, nodes.reference):
            link = pending_xref("", literal.deepcopy(), refdomain="py", reftype="obj", reftarget=name, refdoc=document)
            literal.replace_self(link)


def shorten_sidebar(app: Sphinx, doctree: nodes.document) -> None:
    """Leaves the pages of single names out of the sidebar, where they take two fifths of the time to build the site."""
    if app.env.current_document.docname.startswith("api/"):
        for toctree in list(doctree.findall(autosummary_toc)):
            toctree.parent.remove(toctree)


def visit_inline_math(writer: HTML5Translator, node: nodes.math) -> None:
    """A formula within a line."""
    writer.body.append(mathml(node, as_block=False))
    raise nodes.SkipNode


def visit_block_math(writer: HTML5Translator, node: nodes.math_block) -> None:
    """A formula on lines of its own."""
    writer.body.append(f'<div class="math">{mathml(node, as_block=True)}</div>')
    raise nodes.SkipNode


def mathml(node: nodes.Element, *, as_block: bool) -> str:
    """A formula as MathML, with a thin space between a function and its argument."""
    formula: str = tex2mathml(node.astext(), as_block=as_block)
    return formula.replace("<mo>&ApplyFunction;</mo>", '<mspace width="0.17em"/>')


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    app.add_html_math_renderer("mathml", (visit_inline_math, None), (visit_block_math, None))
    app.connect("builder-inited", run_scripts, priority=100)  # before autosummary
    app.connect("doctree-read", link_public_names)
    app.connect("doctree-read", shorten_sidebar, priority=400)  # before Sphinx collects the toctrees
