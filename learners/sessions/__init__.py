"""What all trainings share: seeds, folders, checkpoints, interrupts."""
