"""Simulations of trees of joints in the coordinates of the joints."""
