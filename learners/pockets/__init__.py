"""Training of the pocket network, which estimates how much unknown free space is behind a frontier cluster.

``train`` flies planners over ``maps`` for ``examples``, then ``learning`` fits the torch network to them, which
``validation`` judges. The network that flies, its input and its true labels are in
:mod:`indoor_explorers.planners.toolbox.pockets`.
"""
