"""Registration of models made of primitives (thesis chapter 5)."""
