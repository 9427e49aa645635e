"""DARE (Cao et al., ICRA 2025): the commit whose code is run, and the packages that its expert planner imports."""

from __future__ import annotations

from indoor_explorers.planners.toolbox.peers.clone import PublishedCode
from indoor_explorers.planners.toolbox.peers.process import Need

#: The repository, with the files that the expert planner is made of.
DARE = PublishedCode(
    url="https://github.com/marmotlab/DARE",
    commit="9a1c3c984747b354c75374e57bde3a9a7b32c204",
    files={
        "parameter.py": "f5a2c19f512a97872e9fd98fe4c62303ba078eea5ef390a177927b9e6459a70d",
        "classes/utils.py": "52d14807010244568ef64e9dd69fe43d95e163a2f6d0c84df7de0e66975d6196",
        "classes/agent/agent.py": "f4a0d1540f82cfda11e7e17f3ca5524ffadd35998d4f7ef5fed6f7c1db6bdf3d",
        "classes/agent/node_manager.py": "1471c973874c71c1fed27562f4f6aca7d932814ed0d0321dddd2c665dbd9c4c8",
        "classes/agent/quads.py": "b6e2efa63d526d89973c271f98cb30231dfd02f79c08bce69c08d57f2217d242",
        "classes/planner/expert_planner.py": "954479d7afe3f9f98eb6b056a038ed5f584c8236bb0c9ad5d6690c6febc55153",
        "classes/planner/ortools_solver.py": "3103b65ca6502f84b732bd2881f52f23de033620b0b0e4f9cac0195eaecce9fa",
    },
)
#: What the expert planner imports.
EXPERT_NEEDS = (
    Need(package="numpy", below=2),
    Need(package="scikit-image", module="skimage"),
    Need(package="imageio"),
    Need(package="ortools"),
)
