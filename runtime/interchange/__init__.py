"""Exchange with other packages and other bases: one module for each."""
