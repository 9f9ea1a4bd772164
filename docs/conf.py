"""The site: what Sphinx makes of docs/, of examples/ and of the docstrings. `make docs` calls it."""

import os
import re
import sys
from importlib.metadata import version as version_of
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE / "reference"), str(HERE / "interactive"), str(HERE / "paper")]

project = "Fuzzyfleet"
author = "The Fuzzyfleet developers"
copyright = f"2026, {author}"
version = release = version_of("fuzzyfleet")

extensions = [
    "mathml",
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.intersphinx",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
]
# What the gallery makes beside its pages is no page.
exclude_patterns = [
    *("_build/**", "examples/**", "**/README.md", "paper/paper.md", "paper/made/paper.md"),
    *(f"gallery/**/*.{ending}" for ending in ("ipynb", "json", "py", "zip")),
]
nitpicky = False

# Pages: Markdown that may be a notebook, executed while the site is built; docstrings in Google's style
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3
nb_execution_mode = "cache"
nb_execution_raise_on_error = False  # its warning ends the build (-W), and shows what failed
nb_execution_show_tb = True
nb_execution_timeout = 900  # s a cell: the site is made beside the tests
nb_output_stderr = "warn"  # a warning of a cell ends a build with -W
# Kernels of this build talk to it alone: that their sockets are not encrypted need not be said for each page.
os.environ["IPYTHONDIR"] = str(HERE / "_build" / "ipython")
kernel_settings = HERE / "_build" / "ipython" / "profile_default" / "ipython_kernel_config.py"
kernel_settings.parent.mkdir(parents=True, exist_ok=True)
kernel_settings.write_text("get_config().IPKernelApp.log_level = 'ERROR'\n", encoding="utf-8")
nb_merge_streams = True  # lines that are printed one by one are one box
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
napoleon_use_ivar = True  # the fields of a class as one list
autodoc_member_order = "bysource"
napoleon_use_rtype = False
html_math_renderer = "mathml"
# The names of other packages are links where there is a network to fetch their lists from.
intersphinx_mapping = (
    {
        "python": ("https://docs.python.org/3", None),
        "numpy": ("https://numpy.org/doc/stable", None),
        "scipy": ("https://docs.scipy.org/doc/scipy", None),
        "matplotlib": ("https://matplotlib.org/stable", None),
        "pandas": ("https://pandas.pydata.org/docs", None),
    }
    if os.environ.get("DOCS_ONLINE")
    else {}
)

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "backreferences_dir": "gallery/backreferences",
    "doc_module": ("anfis", "fuzzy", "robotics"),
    "abort_on_example_error": True,
    "remove_config_comments": True,
    "show_memory": False,
    "download_all_examples": False,
    "write_computation_times": False,
    "plot_gallery": True,
    "image_scrapers": ("figurescraper.scrape",),
    "capture_repr": (),
    "subsection_order": [f"../examples/{part}" for part in ("systems", "learning", "robots", "teams")],
    "within_subsection_order": "figurescraper.InReadingOrder",
    "min_reported_time": 1e9,
}

html_theme = "pydata_sphinx_theme"
html_title = "Fuzzyfleet"
html_static_path = ["static"]
html_favicon = "static/icon.svg"
html_css_files = ["site.css"]
html_context = {"default_mode": "auto"}
html_theme_options = {
    "navbar_align": "left",
    "navigation_with_keys": True,
    "show_toc_level": 2,
    "footer_start": ["copyright"],
    "footer_end": [],
    "pygments_light_style": "tango",
    "pygments_dark_style": "github-dark",
}
html_show_sourcelink = False


def setup(app) -> None:  # type: ignore[no-untyped-def]
    """Write the pages that are made of the program before Sphinx looks for sources."""
    import article
    import interactive
    import pages
    from jupyter_cache import get_cache

    from benchmarks.designerpictures import take_if_changed

    made = HERE / "howto" / "designer" / "made"

    def escaped(app, what, name, thing, options, lines) -> None:  # type: ignore[no-untyped-def]
        lines[:] = [pages.escaped(line) for line in lines]

    def picture(name: str) -> str:
        """Where a picture of the designer is: taken for this site or, without a browser, beside the page."""
        return f"designer/made/{name}" if (made / name).exists() else f"designer/{name}"

    def inside(app, page, lines) -> None:  # type: ignore[no-untyped-def]
        """Links of pages that are also read beside the code: what is no page here is named and not linked."""
        text = lines[0].replace("](../CONTRIBUTING.md)", "](contributing.md)")
        text = re.sub(r"\]\(designer/([\w-]+\.webp)\)", lambda found: f"]({picture(found[1])})", text)
        lines[0] = re.sub(r"\[([^\]]+)\]\(\.\./examples/[^)]*\)", r"`docs/\1`", text)

    app.connect("source-read", inside)
    app.connect("config-inited", lambda app, config: pages.write(HERE / "reference"))
    app.connect("config-inited", lambda app, config: interactive.write(HERE / "interactive"))
    app.connect("config-inited", lambda app, config: article.write(HERE / "paper"))
    app.connect("config-inited", lambda app, config: take_if_changed(made))
    # Pages are read by several processes, of which each would make the table of what was executed
    app.connect("config-inited", lambda app, config: get_cache(Path(app.outdir).parent / ".jupyter_cache").db)
    app.connect("autodoc-process-docstring", escaped)
