"""Commands that build on comparisons: benchmarks, ablations, the thesis, leaderboards, maps, trainings.

``training`` runs one training for a command, ``many_trainings`` those of ``ablation`` and ``thesis``. How a training
goes on, is recorded and resumed is not decided here but by the learners: :mod:`indoor_explorers.learners.sessions`.
"""
