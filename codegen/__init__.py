"""Code generation: mathematics in, source text out."""
