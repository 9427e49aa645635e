"""Information gain: the unknown cells that a scan from a cell may reveal, and the candidates for one."""
