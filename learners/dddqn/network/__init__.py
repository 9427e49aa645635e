"""The network: its torch model for training and its compiled inference."""
