"""Sources of the stock algebras, written by `bladesmith generate`; do not edit."""
