"""The bundled office floor."""
