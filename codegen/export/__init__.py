"""Code that leaves home: kernels and algorithms as source files of other languages, which need nothing of this package.

A kernel becomes a function of the loop IR (`kernel_functions`), an algorithm is one already, and so are the elementary
functions: what is exported is a list of such functions with a description (`unit`), and a language is a printer of the
loop IR with a template (`languages`).
"""
