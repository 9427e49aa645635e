"""Style of tables, charts and figures: colours, formats of numbers, fonts."""
