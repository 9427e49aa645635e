"""In which order to visit places: tours, least latency, short sequences."""
