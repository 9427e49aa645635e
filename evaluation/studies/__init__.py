"""Commands that build on comparisons: benchmarks, ablations, the thesis, leaderboards, maps, trainings.

``training`` runs one training for a command, ``many_trainings`` the trainings of ``ablation`` and ``thesis``. How a
training proceeds, is recorded and resumed is up to the learners: :mod:`indoor_explorers.learners.sessions`.
"""
