"""The one place that states the version, for setup.py, the cache key and `bladesmith.__version__`."""

__version__ = "0.1.0"
