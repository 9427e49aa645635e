"""The interface of policies: views, briefings, pilots, and how policies are found by name."""
