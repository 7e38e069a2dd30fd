"""How Sphinx builds the documentation site: ``make docs``."""

from __future__ import annotations

import os
import sys
from pathlib import Path

DOCS = Path(__file__).parent
sys.path[:0] = [str(DOCS / "_ext"), str(DOCS)]

from sphinx.util.inspect import TypeAliasForwardRef  # noqa: E402

import hazbot_gym  # noqa: E402
from hazbot_gym.utils import provenance  # noqa: E402

# Sphinx shows an alias within another type by its repr.
TypeAliasForwardRef.__repr__ = lambda self: self.name  # type: ignore[method-assign]

project = "hazbot_gym"
author = "The hazbot_gym authors"
copyright = f"2026, {author}"
version = release = hazbot_gym.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "mathml",
    "generated",
    "animations",
    "results",
    "scenes",
]
exclude_patterns = ["_build", "_ext", "_templates_md"]
nitpicky = False

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3
html_math_renderer = "mathml"

# Notebooks are committed without outputs and run in a temporary folder when the site is built; what
# an earlier build ran with the same code is kept.
nb_execution_mode = "cache"
nb_execution_cache_path = str(DOCS / "_build" / "notebooks" / provenance.stamp())
nb_execution_in_temp = True
nb_execution_timeout = 240
nb_execution_raise_on_error = True
nb_output_stderr = "remove"
os.environ["MATPLOTLIBRC"] = str(DOCS / "_ext")  # figures that suit the light and the dark theme

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_class_signature = "mixed"
autodoc_preserve_defaults = True
napoleon_numpy_docstring = False
napoleon_use_rtype = False
napoleon_preprocess_types = False
napoleon_use_ivar = True
# Written as in the source, not as the arrays that they stand for.
autodoc_type_aliases = {
    name: name for name in ("Actions", "Flags", "Floats", "Ints", "Observations", "Records", "Row")
}

html_theme = "furo"
html_title = "hazbot_gym"
html_favicon = "_static/favicon.svg"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {
    "light_css_variables": {
        "color-brand-primary": "#0b6e6e",
        "color-brand-content": "#0b6e6e",
    },
    "dark_css_variables": {
        "color-brand-primary": "#4fc4bd",
        "color-brand-content": "#4fc4bd",
    },
}
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
