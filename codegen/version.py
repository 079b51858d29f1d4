"""The one place that states the version: setup.py, the cache key and `bladesmith.__version__` read it here."""

__version__ = "0.1.0"
