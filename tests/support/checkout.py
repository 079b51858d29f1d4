"""The folder of the checkout, from which tests make every path."""

from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[2]
