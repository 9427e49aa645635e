"""The script that drives IR2; if asked for, with the simulator's own functions in place of the faster ones."""

from __future__ import annotations

import os
from importlib import import_module, util
from pathlib import Path
from typing import Any

KEPT = {
    "env": ("sensor_work",),
    "node.Node": ("check_collision",),
    "graph.Graph": ("__deepcopy__",),
    "graph.Edge": ("__deepcopy__",),
    "graph_generator.Graph_generator": ("check_collision", "find_k_neighbor", "find_k_neighbor_custom"),
}
PRODUCT = Path(__file__).parents[4] / "evaluation/studies/peers/ir2_script.py"


def _owner(path: str) -> Any:
    module, _, name = path.partition(".")
    return getattr(import_module(module), name) if name else import_module(module)


import_module("test_parameter")
own = {(path, name): vars(_owner(path)).get(name) for path, names in KEPT.items() for name in names}
spec = util.spec_from_file_location("_product", PRODUCT)
assert spec is not None
assert spec.loader is not None
script: Any = util.module_from_spec(spec)
spec.loader.exec_module(script)
if os.environ.get("OWN_FUNCTIONS"):
    for (path, name), function in own.items():
        if function is None:
            delattr(_owner(path), name)
        else:
            setattr(_owner(path), name, function)
begin, move = script.begin, script.move
