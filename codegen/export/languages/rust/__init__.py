"""Rust: one module without `std`, in which a kernel takes and returns structs and an algorithm slices of numbers."""
