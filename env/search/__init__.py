"""What planners and learners both compute from a map: searches, visibility, sets of cells."""
