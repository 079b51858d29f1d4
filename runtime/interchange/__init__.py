"""Exchange with other packages, one module for each."""
