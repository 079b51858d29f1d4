"""Dynamics of links on a tree of joints: chains, and robots that branch."""
