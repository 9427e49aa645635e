"""Floor plans of schools, offices and university buildings."""
