"""The folders that plug-ins start from: a small one of each kind that works, with its test and a comparison."""
