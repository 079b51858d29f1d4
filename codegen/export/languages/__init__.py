"""Languages: a printer of the loop IR and a template of a file for each."""
