"""The grid: cell values, moves, arrays and their types, random streams, and how compiled code is made."""
