"""Results of kernels reduced over the items of a batch, without an array of them."""
