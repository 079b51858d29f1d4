"""All postures of arms of six rotations: closed forms, and an elimination for any other arm."""
