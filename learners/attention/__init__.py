"""Graph attention over viewpoints, trained by discrete soft actor-critic: the architecture of ARiADNE.

Y. Cao, T. Hou, Y. Wang, X. Yi, G. Sartoretti, "ARiADNE: A Reinforcement learning approach using Attention-based Deep
Networks for Exploration", ICRA 2023 (arXiv:2301.11575); with the privileged critic of Y. Cao, R. Zhao, Y. Wang, B.
Xiang, G. Sartoretti, "Deep Reinforcement Learning-based Large-scale Robot Exploration", RA-L 2024 (arXiv:2403.10833).

To fly: ``policy`` chooses among the neighbours of the UAV's node in a ``graph`` with ``network``, without torch. To
train: ``train`` is the entry point and alternates ``flights`` and updates of ``sac``, with the networks of ``model``.
"""
