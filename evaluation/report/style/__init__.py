"""Number formats, colours, the style of print figures, and packed arrays."""
