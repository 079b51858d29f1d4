"""Jinja2 templates and shared headers; data only."""
