"""One training session for all learners: its folder and record, evaluations, checkpoints, progress, interrupts.

``train`` is the train function of all learners, ``session`` the loop around any learner, ``record`` the
``training.json`` of its folder, ``settings`` the base of all configurations, ``evaluation`` the greedy episodes that
measure the network, ``seeds`` the episode seeds, ``process`` threads and interrupts. ``tensors``, ``checkpoint``,
``networks`` and ``worlds`` write and read the content of checkpoints.
"""
