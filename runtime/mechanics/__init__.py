"""Screws, statics, inertia, shapes, joints: what dynamics and kinematics share."""
