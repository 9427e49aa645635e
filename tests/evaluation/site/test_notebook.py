"""The notebook is the one that the script writes, and its cells print what it says."""

import json
import re
import subprocess
import sys

import pytest

from indoor_explorers.evaluation.site.notebook import CELLS, NOTEBOOK, is_code, notebook

STORED = json.loads(NOTEBOOK.read_text("utf-8"))
#: Spares the comparison the figures for print, which would take most of its time.
RUN = """
import json
from indoor_explorers.evaluation import exports
from indoor_explorers.evaluation.site import notebook

exports.write_figures = lambda *_: []
print(json.dumps(notebook.printed()))
"""


def outputs_of(cells):
    return ["".join(line for out in cell["outputs"] for line in out["text"]) for cell in cells if "outputs" in cell]


def test_the_stored_notebook_is_that_of_the_script_and_has_ten_cells():
    assert notebook(outputs_of(STORED["cells"])) == STORED
    assert len(STORED["cells"]) == len(CELLS) == 10
    assert [cell["cell_type"] for cell in STORED["cells"]] == ["markdown", "code"] * 5


def test_it_has_what_jupyter_demands_of_version_4_5():
    assert (STORED["nbformat"], STORED["nbformat_minor"]) == (4, 5)
    assert len({cell["id"] for cell in STORED["cells"]}) == 10
    for number, cell in enumerate(STORED["cells"]):
        code = {"execution_count", "outputs"} if is_code(CELLS[number]) else set()
        assert cell.keys() == {"cell_type", "id", "metadata", "source"} | code
        assert re.fullmatch(r"[a-zA-Z0-9-_]{1,64}", cell["id"])
        assert "".join(cell["source"]) == CELLS[number].rstrip("\n")
        for output in cell.get("outputs", []):
            assert (output["output_type"], output["name"]) == ("stream", "stdout")
    assert [cell["execution_count"] for cell in STORED["cells"] if "outputs" in cell] == [1, 2, 3, 4, 5]


@pytest.mark.slow
def test_its_cells_print_what_it_stores_and_the_replay_is_there(tmp_path):
    done = subprocess.run([sys.executable, "-P", "-c", RUN], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    printed = json.loads(done.stdout)
    assert printed == outputs_of(STORED["cells"])
    path, _, address = printed[-1].strip().partition("#")
    page = (tmp_path / path).read_text("utf-8")
    section, task = re.match(r"replay=(\w+);task=(\d+,\d+);", address).groups()
    assert f'id="replay-{section}"' in page
    assert f'"task":[{task}]' in page
