"""The `bladesmith` command."""
