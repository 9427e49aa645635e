"""The DDDQN of the IndoorExplorers thesis (2023) as it was, its mistakes included, each of them a switch."""
