"""Networks without torch: the layers that fly trained weights, and the files that hold them."""
