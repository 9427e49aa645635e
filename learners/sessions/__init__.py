"""One training session for all learners: its folder and record, evaluations, checkpoints, progress, interrupts.

``session`` is the loop around any learner, ``record`` the ``training.json`` of its folder, ``evaluation`` the greedy
episodes that tell how good it is, ``seeds`` where episodes come from, ``process`` what a training asks of its process.
``tensors``, ``checkpoint``, ``networks`` and ``worlds`` write and read what checkpoints hold.
"""
