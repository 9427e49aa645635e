"""A plug-in whose module cannot be imported."""

raise RuntimeError("licence\nexpired")
