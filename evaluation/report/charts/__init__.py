"""Charts of the page: interactive ones as data, small ones as inline SVG."""
