"""The reference tour: a yardstick that knows the map."""
