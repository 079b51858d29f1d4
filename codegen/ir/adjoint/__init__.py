"""Reverse derivatives of algorithms: the text of one without jumps and calls, what it keeps, and its adjoint."""
