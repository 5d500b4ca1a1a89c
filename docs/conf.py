"""The documentation site: `python -m sphinx -W -b html docs build/site`.

The API reference is made from the docstrings of all public names, which `__init__.pyi` lists. Formulas become MathML,
so that a page needs no network and no script.
"""

from __future__ import annotations

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

import ropeway

project = "ropeway"
author = "the authors of ropeway"
release = version = ropeway.__version__

extensions = ["myst_parser", "numpydoc", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx_design"]
exclude_patterns = ["_templates"]
templates_path = ["_templates"]
root_doc = "index"

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

html_theme = "furo"
html_title = f"ropeway {release}"
html_math_renderer = "mathml"
html_show_sourcelink = False
html_copy_source = False

autosummary_generate = True
autosummary_imported_members = True
autosummary_ignore_module_all = False
autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False

PUBLIC = {f"{prefix}{name}": f"{module}.{name}" for module, prefix, names in (
    ("ropeway", "", ropeway.__all__), ("ropeway", "rw.", ropeway.__all__), ("ropeway.fmu", "rw.fmu.", ropeway.fmu.__all__)
) for name in names}
"""A public name as the documents write it, and its full name."""


def link_public_names(app: Sphinx, doctree: nodes.document) -> None:
    """Makes every public name in a document a link to its page; names without `rw.` only in the list of names."""
    document = app.env.docname
    if document.startswith("api/"):
        return
    for literal in list(doctree.findall(nodes.literal)):
        written = literal.astext().removesuffix("()")
        if written not in PUBLIC or ("." not in written and document != "names"):
            continue
        link = pending_xref("", literal.deepcopy(), refdomain="py", reftype="obj", reftarget=PUBLIC[written],
                            refexplicit=True, refdoc=document, refwarn=True)
        literal.replace_self(link)


def visit_inline_math(writer: HTML5Translator, node: nodes.math) -> None:
    """A formula within a line."""
    writer.body.append(tex2mathml(node.astext()))
    raise nodes.SkipNode


def visit_block_math(writer: HTML5Translator, node: nodes.math_block) -> None:
    """A formula on lines of its own."""
    writer.body.append(f'<div class="math">{tex2mathml(node.astext(), as_block=True)}</div>')
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Registers the two above."""
    app.add_html_math_renderer("mathml", (visit_inline_math, None), (visit_block_math, None))
    app.connect("doctree-read", link_public_names)
