"""TOML and JSON files of users: positions of keys, schemas, and errors that say file, line, key and remedy."""
