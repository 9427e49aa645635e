"""A learner that chooses places: which frontier cluster to fly to, by a dueling network over the set of all of them.

To fly: ``policy`` values the places of a ``scene`` with ``network``, without torch. To train: ``train`` alternates
``flights``, which record choices and the ``truth`` about them, and ``learning`` with the torch networks of ``model``.
"""
