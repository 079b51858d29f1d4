"""JavaScript: an ES module and its declarations of types, in which structs are objects and all real numbers float64.

An array is the array and where in it to begin. Local arrays are made once: nothing calls itself. Integers are numbers,
exact to 53 bits; in functions that work on bits they are of type BigInt, and wrap to 64.
"""
