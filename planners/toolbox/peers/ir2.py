"""IR2 (Tan et al., IROS 2024): the commit whose simulator is run, and whose network is read."""

from __future__ import annotations

from indoor_explorers.planners.toolbox.peers.clone import PublishedCode

#: The repository, with the files that both the simulator and what the network sees are made of.
IR2 = PublishedCode(
    url="https://github.com/marmotlab/IR2",
    commit="e53a6fc2c384c7b55a393968b8b85d5b401075e5",
    files={
        "graph_generator.py": "dc1fedf48624981d3958c95200eb8e8440221edd87b7b42341900f4b06af3d04",
        "node.py": "d156b1089d75f05a4323e0ece65362b9e850d7a2c7b0690f4d360ad8fb043e53",
        "env.py": "6cad60ce769e35d5f3404229d081b665b70a4e70749a11e6f48214c61b2c0bd9",
    },
)
