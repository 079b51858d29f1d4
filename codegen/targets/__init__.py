"""One printer per target language, and the texts they make."""
