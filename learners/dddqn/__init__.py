"""Dueling double deep Q-learning.

What the network sees: ``layout`` (where everything is), ``observation`` with ``scene``, ``gains``, ``prospects`` and
``tours`` (over ``beam`` and ``optimistic_map``), ``prior`` (the learned map prior), ``sensor`` and
``memory``. To act: ``inference`` (the compiled network), ``weights`` (files), ``policy``. To train: ``network``,
``replay`` with ``priorities``, ``targets``, ``learner`` (one update), ``flock`` (UAVs in training), ``surveys`` (fits
the prior), ``trial`` (evaluation), ``training`` (all of it as one object), ``train`` (the loop), ``scalars``,
``config`` (every switch) and ``presets``. Only training needs torch.
"""
