"""Functions of multivectors: formulas of the code generator by name, with statuses per item."""
