"""The DDDQN of the IndoorExplorers thesis (2023), rebuilt with its mistakes; each mistake is a switch."""
