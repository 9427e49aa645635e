"""The losses that ns-3 gave agree with published formulas, with the floors of today, and with what the page says."""

import importlib.util
import subprocess
import sys

import numpy as np
import pytest

from indoor_explorers.env import scenario
from indoor_explorers.env.simulation.radio import in_reach
from indoor_explorers.env.simulation.state import rules_of
from indoor_explorers.evaluation.site.pictures.radio import RANGE
from indoor_explorers.evaluation.site.studies.radio_comparison import (
    DEFAULTS,
    MEASURED,
    OFFICE,
    RANGES,
    contacts,
    floors,
    loss,
    measured,
    model_table,
    pairs_of,
    range_table,
    room_grid,
)
from tests.documents import SITE

PAGE = (SITE / "pages" / "methods-radio.md").read_text("utf-8")
DECIMALS = 0.0005 + 1e-9


def test_the_page_has_the_tables_of_the_measured_losses():
    for rows in (range_table(), model_table(RANGE)):
        assert "\n".join(rows) in PAGE


def test_the_page_says_how_far_the_losses_are_apart():
    pairs = measured()
    ours = loss(pairs, *DEFAULTS)
    lower, walls, rooms = ours - pairs["ns3_db"], pairs["walls"], pairs["rooms"]
    text = " ".join(PAGE.split())
    assert f"correlate by {np.corrcoef(ours, pairs['ns3_db'])[0, 1]:.2f}; ns-3's is {lower.mean():.1f} dB lower" in text
    assert f"standard deviation of {lower.std():.1f} dB" in text
    assert f"equal on {(rooms == walls).mean():.0%} ".replace("%", " %") in text
    assert (
        f"differ by {abs(rooms - walls).mean():.1f} on average; they correlate by {np.corrcoef(rooms, walls)[0, 1]:.2f}"
        in text
    )
    in_contact = pairs["metres"][contacts(pairs, RANGE)["ns-3"]]
    with_a_wall = RANGE * 10 ** (-OFFICE[1] / (10 * OFFICE[0]))
    assert in_contact.max() <= with_a_wall
    assert f"no pair farther apart than {with_a_wall:.1f} m" in text


def test_the_pairs_and_rooms_are_those_of_the_floors():
    pairs = measured()
    for seed, plan in floors():
        rows = pairs[pairs["seed"] == seed]
        grid, side = room_grid(plan), plan.resolution
        assert rows[["row", "col", "to_row", "to_col", "walls"]].to_numpy().tolist() == [
            list(pair) for pair in pairs_of(seed, plan)
        ], f"floors have changed: run {MEASURED.stem}.py again"
        x, to_x = (((rows[end] + 0.5) * side - grid.left) / (grid.right - grid.left) for end in ("col", "to_col"))
        y, to_y = (((rows[end] + 0.5) * side - grid.top) / (grid.bottom - grid.top) for end in ("row", "to_row"))
        across = abs((x * grid.across // 1) - (to_x * grid.across // 1))
        down = abs((y * grid.down // 1) - (to_y * grid.down // 1))
        assert (across + down == rows["rooms"]).all()


def test_losses_are_those_of_p1238_and_walls():
    pairs = measured()
    of_distance = 30 * np.log10(pairs["metres"])
    assert abs(of_distance + 5 * pairs["rooms"] - pairs["ns3_db"]).max() <= DECIMALS
    assert abs(of_distance + 5 * pairs["walls"] - pairs["ns3_walls_db"]).max() <= DECIMALS
    assert (pairs["ns3_shadowed_db"] - pairs["ns3_db"]).std() == pytest.approx(8, abs=0.3)


@pytest.mark.parametrize("model", ["`path-loss`, defaults", "COST 231, heavy walls"])
def test_contacts_are_those_of_the_world(model):
    exponent, wall_loss = {"`path-loss`, defaults": DEFAULTS}.get(model, (2.0, 6.9))
    pairs, plans = measured(), dict(floors())
    for metres in RANGES:
        radio = {"radio.model": "path-loss", "radio.range": metres / 0.5}
        radio |= {"radio.exponent": exponent, "radio.wall_loss": wall_loss}
        rules = rules_of(scenario("floors").with_settings(radio))
        cells = pairs[["seed", "row", "col", "to_row", "to_col"]].itertuples(index=False)
        found = [in_reach.py_func(rules, plans[seed].truth, *ends) for seed, *ends in cells]
        assert (contacts(pairs, metres)[model] == found).all()


@pytest.mark.slow
@pytest.mark.skipif(
    importlib.util.find_spec("ns3") is None, reason="needs ns-3, a tool beside the tests: pip install ns3"
)
def test_ns3_gives_what_is_written(tmp_path):
    module = "indoor_explorers.evaluation.site.studies.radio_ns3"
    code = f"from pathlib import Path; from {module} import main; main(Path('again.csv'))"
    subprocess.run([sys.executable, "-P", "-c", code], cwd=tmp_path, check=True, capture_output=True, timeout=300)
    assert (tmp_path / "again.csv").read_bytes() == MEASURED.read_bytes()
