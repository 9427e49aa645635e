"""A learner that chooses places: which frontier cluster to fly to, by a dueling network over the set of all of them.

To fly: ``policy`` and its ``pilot`` value the places of a ``scene`` with ``network``, without torch. To train:
``train`` is the entry point, ``training`` alternates ``flights``, whose ``choices`` it keeps in files beside the
``truth``, and ``learning`` with the torch networks of ``model``.
"""
