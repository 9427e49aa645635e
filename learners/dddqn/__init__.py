"""Dueling double deep Q-learning.

To act: ``sensor`` and ``observation`` (what the network sees), ``inference`` (the compiled network),
``weights`` (files), ``policy``. To train: ``network``, ``replay`` with ``symmetry``, ``targets``,
``learner`` (one update), ``flock`` (UAVs in training), ``trial`` (evaluation), ``training`` (all of it as
one object), ``train`` (the loop), ``config`` and ``provenance``. Only training needs torch.
"""
