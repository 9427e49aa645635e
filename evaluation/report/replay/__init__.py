"""Which episodes the page replays, and how they are packed."""
