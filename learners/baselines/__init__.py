"""Baselines: learners of Stable-Baselines3, sb3-contrib and RLlib.

Training: ``sb3_ppo``, ``sb3_a2c``, ``sb3_dqn``, ``sb3_qrdqn`` and ``sb3_maskable_ppo`` (Stable-Baselines3 and
sb3-contrib, one UAV), ``rllib_ppo`` and ``rllib_sac`` (RLlib, one UAV or a team with shared parameters); each module
has a ``TrainingConfig`` and a ``train``. They share ``config``, ``trainee`` (evaluation and the interface to the
training session), and ``sb3_training`` or ``rllib_training``. Acting: ``acting``, ``stable_baselines`` and ``rllib``,
the policies ``sb3:DIR`` and ``rllib:DIR``. A library is imported only when one of its learners or policies is used.
"""
