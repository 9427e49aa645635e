"""The playground: one page, without a server, on which a small team explores a map that the reader draws."""
