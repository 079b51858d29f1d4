"""Robots as source files of other languages: kinematics of chains, Delta robots and mechanisms, with their numbers."""
