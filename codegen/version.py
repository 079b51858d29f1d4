"""The one place that states the version, for setup.py, the cache key and `bladesmith.__version__`; and the site."""

__version__ = "0.1.0"

#: Address of the site: "Documentation" of pyproject.toml.
SITE = "https://bladesmith.readthedocs.io"


def site_page(name: str) -> str:
    """Address of a page of the site, ``algebra/specs``: of the version that is shown by default."""
    return f"{SITE}/page/{name}.html"
