"""Folders that tests write to."""


def names(folder):
    """The names of the files of a folder, in order."""
    return sorted(p.name for p in folder.iterdir())
