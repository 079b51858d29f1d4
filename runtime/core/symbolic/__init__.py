"""Multivectors whose coefficients are SymPy expressions. Imported when one is made: SymPy takes half a second."""
