"""Dueling double deep Q-learning (DDDQN).

``observation`` computes the network's input from one UAV's view. ``network`` is the network, as a torch model for
training and compiled for acting. ``learning`` holds vectorised flight, replay, targets and updates. Each
folder imports only those before it. ``policy``, ``pilot`` and ``weights`` are for acting, ``tours`` is the policy
without the network, ``train`` and ``config`` for training, ``presets`` are named trainings and ablations. Only
training needs torch.
"""
