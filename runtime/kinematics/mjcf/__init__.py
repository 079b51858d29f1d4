"""Robots from MJCF files, the format of MuJoCo, and into them."""
