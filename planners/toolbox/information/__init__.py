"""Information gain: what a scan from a cell would newly show, and the candidates that are worth one."""
