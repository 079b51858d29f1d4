"""One module per study, each with a `Study` named STUDY."""
