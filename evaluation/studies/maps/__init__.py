"""What floors are like, and how far generated ones are from given ones."""
