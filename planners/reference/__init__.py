"""The reference tour: a good tour, found with the map known, and no bound."""
