"""Rows of others are read from every format, all of them or none."""

import builtins
import json

import pandas as pd
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.harness.reported.importing import BadRows, imported, map_name
from indoor_explorers.evaluation.harness.reported.rows import joined, read_reported, write_reported
from indoor_explorers.evaluation.harness.results.results import Results

SOURCE = '[source]\ncitation = "Doe 2024"\nurl = "https://example.org/a"\n'
TOML = f"""
policy = {{ column = "method" }}
scenario = {{ column = "set", names = {{ small = "our-rooms" }} }}
map = {{ column = "map" }}
seed = {{ column = "seed" }}
team = 2
budget = 300
{SOURCE}
[metrics]
path_length = {{ column = "px", factor = 0.5 }}
t99 = {{ column = "time" }}
auc = {{ column = "auc" }}
[success]
column = "ok"
level = 0.99
"""
MEANS = f"""
policy = "theirs"
scenario = "our-rooms"
mean = true
n = {{ column = "n" }}
{SOURCE}
[metrics]
t99 = {{ column = "time" }}
[success]
column = "ok"
level = 0.99
"""
ROW = {"method": "a", "set": "small", "map": "test/9.png", "seed": 3, "px": 40, "time": 120, "auc": 0.8, "ok": True}
ROWS = [ROW, {**ROW, "seed": 4, "time": None, "ok": False}, {**ROW, "method": "b"}]


def written(folder, rows, ending="csv", toml=TOML):
    path = folder / f"rows.{ending}"
    path.with_suffix(".toml").write_text(toml)
    table = pd.DataFrame(rows)
    if ending == "csv":
        table.to_csv(path, index=False)
    elif ending == "json":
        path.write_text(json.dumps(rows))
    else:
        table.to_parquet(path)
    return path


def faults(folder, rows, toml=TOML):
    with pytest.raises(BadRows) as caught:
        imported([written(folder, rows, "json", toml)])
    return caught.value.faults


@pytest.mark.parametrize("ending", ["csv", "json", "parquet"])
def test_every_format_gives_the_same_rows_in_the_units_of_this_package(tmp_path, ending):
    first, second = imported([written(tmp_path, ROWS, ending)])
    assert (first.name, second.name, first.level, first.source.citation) == ("a", "b", 0.99, "Doe 2024")
    one, other = first.rows
    assert (one.scenario, one.map, one.seed, one.team, one.budget) == ("our-rooms", "9", 3, 2, 300)
    assert one.metrics == {"path_length": 20.0, "t99": 120.0, "auc": 0.8}
    assert other.metrics["t99"] is None
    assert [one.success, other.success] == [True, False]


def test_without_pyarrow_parquet_is_refused_in_one_line(tmp_path, monkeypatch):
    path, load = written(tmp_path, ROWS, "parquet"), builtins.__import__

    def lacking(name, *args, **more):
        if name.partition(".")[0] in ("pyarrow", "fastparquet"):
            raise ImportError(name)
        return load(name, *args, **more)

    monkeypatch.setattr(pd, "read_parquet", lambda source: lacking("pyarrow"))
    with pytest.raises(InputError, match="Parquet needs pyarrow; install it, or convert"):
        imported([path])


@pytest.mark.parametrize(
    ("change", "column", "expected"),
    [
        ({"method": ""}, "method", "expected a valid string, got ''"),
        ({"set": "large"}, "set", "expected one of small, which its table of names has, got 'large'"),
        ({"map": None}, "map", "expected a valid string, got None"),
        ({"seed": 1.5}, "seed", "expected a valid integer, got a number with a fractional part, got 1.5"),
        ({"seed": -1}, "seed", "expected greater than or equal to 0, got -1"),
        ({"px": "far"}, "px", "expected a valid number, unable to parse string as a number, got 'far'"),
        ({"px": None}, "px", "expected a valid number, got None"),
        ({"px": -1}, "px", "expected greater than or equal to 0, got -1"),
        ({"time": "inf"}, "time", "expected a finite number, got 'inf'"),
        ({"auc": 80}, "auc", "expected less than or equal to 1, got 80"),
        ({"ok": "maybe"}, "ok", "expected a valid boolean, unable to interpret input, got 'maybe'"),
    ],
)
def test_a_bad_row_gets_a_line_with_its_place_and_what_was_expected(tmp_path, change, column, expected):
    (line,) = faults(tmp_path, [ROW, {**ROW, "seed": 9, **change}])
    assert line.startswith(f"{tmp_path}/rows.json, row 2, column '{column}': {expected}")


def test_an_empty_time_needs_a_budget_and_a_task_has_one_row(tmp_path):
    (line,) = faults(tmp_path, ROWS, TOML.replace("budget = 300", ""))
    assert "row 2, column 'time': expected a valid number" in line
    (line,) = faults(tmp_path, [ROW, ROW])
    assert "row 2, all columns: expected another task, got that of row 1 again" in line


def test_rows_of_a_csv_file_are_counted_by_line_and_have_as_many_cells_as_columns(tmp_path):
    path = written(tmp_path, [ROW])
    path.write_text(path.read_text() + "a,small,9.png,5,1,1,0.5,True,more\n\na,small\n")
    with pytest.raises(BadRows) as caught:
        imported([path])
    assert caught.value.faults == [
        f"{path}, row {row}, the end: expected 8 cells, got {cells}" for row, cells in ((3, 9), (5, 2))
    ]


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('url = "https://example.org/a"', "", "source.url"),
        ("example.org", "<script>", "source.url"),
        ("path_length", "path_lenght", "unknown metric 'path_lenght'; did you mean 'path_length'"),
        ('"px"', '"pixels"', "no column 'pixels'"),
        ("factor = 0.5", "factor = 0", "factor"),
        ("level = 0.99", "level = 99", "success.level"),
        ('map = { column = "map" }', "", "expected map, and no n"),
        ("budget", "bugdet", "unknown key 'bugdet'; did you mean 'budget'"),
        ("team = 2", "team = {}", "expected a value, or a table such as"),
        ("team = 2", 'where = { set = "other" }', "expected rows that match where, got none"),
        ("team = 2", 'team = "many"', "team of the TOML file: expected a valid integer"),
    ],
)
def test_a_toml_file_that_does_not_fit_is_refused_in_one_line(tmp_path, before, after, message):
    with pytest.raises(InputError) as caught:
        imported([written(tmp_path, ROWS, toml=TOML.replace(before, after))])
    assert message in "; ".join([str(caught.value), *getattr(caught.value, "faults", [])])


def test_published_means_have_their_number_of_episodes(tmp_path):
    (policy,) = imported([written(tmp_path, [{"n": 50, "time": 210.5, "ok": 0.92}], toml=MEANS)])
    (mean,) = policy.rows
    assert (mean.n, mean.metrics, mean.success, mean.map) == (50, {"t99": 210.5}, 0.92, None)
    assert "expected less than or equal to 1, got 92" in faults(tmp_path, [{"n": 50, "time": 1, "ok": 92}], MEANS)[0]
    assert "another task" in faults(tmp_path, [{"n": 50, "time": 1, "ok": 1}] * 2, MEANS)[0]


def test_names_of_maps_are_the_stems_of_their_files():
    assert [map_name(text) for text in ("99.png", "a/b/99.png", "c\\7.yaml", "floor1.2")] == [
        "99",
        "99",
        "7",
        "floor1.2",
    ]


def test_all_rows_are_imported_or_none(tmp_path, capsys):
    good, folder = written(tmp_path, ROWS), tmp_path / "out"
    assert main(["import", str(good), "--out", str(folder)]) == 0
    assert "a on our-rooms: 2 rows; no preset and no suite has a scenario of this name" in capsys.readouterr().out
    before = (folder / "reported.json").read_bytes()
    (tmp_path / "more").mkdir()
    bad = written(tmp_path / "more", [{**ROW, "method": "c"}, {**ROW, "method": "d", "px": "?"}])
    assert main(["import", str(good), str(bad), "--out", str(folder)]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert (
        lines[0] == f"{bad}, row 3, column 'px': expected a valid number, unable to parse string as a number, got '?'"
    )
    assert lines[1].startswith("indoor-explorers: 1 fault in the rows; nothing was imported")
    assert (folder / "reported.json").read_bytes() == before


def test_a_folder_gains_policies_and_replaces_them_only_when_asked(tmp_path, capsys):
    folder, path = tmp_path / "out", written(tmp_path, ROWS)
    words = ["import", str(path), "--out", str(folder)]
    assert main(words) == main(words) == 0
    written(tmp_path, [{**ROW, "px": 99}])
    assert main(words) == 2
    assert "two reported policies are named 'a' and differ in: rows of 'our-rooms'; give one" in capsys.readouterr().err
    assert main([*words, "--replace"]) == 0
    a, b = sorted(read_reported(folder), key=lambda policy: policy.name)
    assert ([each.metrics["path_length"] for each in a.rows], len(b.rows)) == ([49.5], 1)
    assert Results.load(folder).reported == read_reported(folder)


def test_policies_of_one_name_must_agree(tmp_path):
    (a, _) = imported([written(tmp_path, ROWS)])
    assert joined([a, a]) == (a,)
    source = a.source.model_copy(update={"url": "https://b.org"})
    with pytest.raises(InputError, match="named 'a' and differ in: source, level; give one of them another name"):
        joined([a, a.model_copy(update={"source": source, "level": 0.9})])
    with pytest.raises(InputError, match="'a' is both flown and reported"):
        joined([a], ["a"])


@pytest.mark.parametrize("text", ["{", "[]", '{"format": 2, "policies": []}', '{"policies": [{"name": "x"}]}'])
def test_a_damaged_file_is_refused(tmp_path, text):
    (tmp_path / "reported.json").write_text(text)
    with pytest.raises(InputError, match=r"reported\.json"):
        Results.load(tmp_path)


def test_equal_policies_give_equal_bytes(tmp_path):
    policies = imported([written(tmp_path, ROWS)])
    write_reported(policies, tmp_path)
    first = (tmp_path / "reported.json").read_bytes()
    write_reported(read_reported(tmp_path), tmp_path)
    assert (tmp_path / "reported.json").read_bytes() == first
