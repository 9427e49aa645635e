"""A learner that chooses when to report to a home base, whoever explores, by a small dueling network.

To fly: ``policy`` asks ``network`` about a ``situation``, without torch. To train: ``train`` alternates ``flights``,
which record choices, and ``learning``.
"""
