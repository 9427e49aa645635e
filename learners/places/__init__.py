"""A learner that chooses places: which frontier cluster to fly to, by a dueling network over the set of all of them."""
