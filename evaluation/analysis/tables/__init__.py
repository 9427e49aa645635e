"""Tables of the terminal, the page and the exports."""
