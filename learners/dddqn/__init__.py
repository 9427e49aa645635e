"""Dueling double deep Q-learning.

``observation`` is what the network sees of one UAV's view, ``network`` the network itself, as a torch model to train
and compiled to act, and ``learning`` how it learns: vectorised flight, replay, targets, updates, evaluation. Each
folder imports only those before it. Beside them stand ``policy`` and ``weights`` (to act), ``train`` and ``config``
(to train), ``presets`` and ``ablations`` (named trainings). Only training needs torch.
"""
