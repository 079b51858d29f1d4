"""Multivectors in other forms: on other bases, as matrices, as those of other packages."""
