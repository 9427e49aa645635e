"""Published explorers of other groups, from clones of their repositories."""
