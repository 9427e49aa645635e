"""Baselines: learners of well-kept libraries, trained and flown beside the project's own.

To train: ``sb3_ppo``, ``sb3_a2c``, ``sb3_dqn``, ``sb3_qrdqn`` and ``sb3_maskable_ppo`` (Stable-Baselines3 and
sb3-contrib, one UAV), ``rllib_ppo`` and ``rllib_sac`` (RLlib, a team with shared parameters, or one UAV); each is
a ``TrainingConfig`` and a ``train``. They share ``config``, ``trainee`` (a model as a training session sees it),
``evaluation``, and ``sb3_training`` or ``rllib_training``; the session itself is that of all learners. To act:
``acting``, ``stable_baselines`` and ``rllib``, the policies ``sb3:DIR`` and ``rllib:DIR``. Libraries load only when one
of their learners or policies is used.
"""
