"""One training session for all learners: its folder and record, evaluations, checkpoints, progress, interrupts.

Each learner has a module ``train`` with its ``TrainingConfig`` and ``train``, which ``indoor-explorers train`` finds by
an entry point, and a trainee, which the session trains. Here ``train`` makes such functions, ``session`` is the loop
around any trainee, ``record`` the ``training.json`` of its folder, ``settings`` the base of all configurations,
``evaluation`` the greedy episodes that measure the network, ``seeds`` the episode seeds, ``process`` threads and
interrupts, ``tensorboard`` the scalars of its progress. ``checkpoint``, ``networks`` and ``worlds`` write and read the
content of checkpoints. ``former`` translates the commands of earlier versions.
"""
