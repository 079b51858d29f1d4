"""Trees of links on joints: inverse and forward dynamics, mass matrices."""
