"""Baselines: learners of well-kept libraries, trained and flown beside the project's own.

To train: ``sb3_ppo``, ``sb3_a2c``, ``sb3_dqn``, ``sb3_qrdqn`` and ``sb3_maskable_ppo`` (Stable-Baselines3 and
sb3-contrib, one UAV), ``rllib_ppo`` and ``rllib_sac`` (RLlib, a team with shared parameters, or one UAV); each is
a ``TrainingConfig`` and a ``train``. They share ``config``, ``record`` (what a folder says about its training),
``session`` (progress, interruptions), ``trial`` (evaluation), ``books`` (when what is written), and
``sb3_training`` or ``rllib_training``. To act: ``acting``, ``stable_baselines`` and ``rllib``, the policies
``sb3:DIR`` and ``rllib:DIR``. Libraries load only when one of their learners or policies is used.
"""
