"""What a declared kernel does: it runs compiled, and has derivatives. `api` declares it."""
