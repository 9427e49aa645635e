"""What is cited is listed and what is listed is cited: papers of the policies, and those of the project's own paper."""

import json
import re
import tomllib

import pytest
import yaml

from tests.bibliography import docstrings, entries, numbers, plain
from tests.documents import ROOT

PAPER = ROOT / "evaluation" / "paper"
#: Policies whose method is from no paper: chance, and a rule of this project.
OWN = {"random", "tours", "level-by-level"}
METHODS = entries(PAPER / "METHODS.bib")


def policies_of(entry):
    return entry["keywords"].removeprefix("policies: ").split(", ")


def number_of(entry):
    return entry.get("doi") or entry.get("eprint")


def test_every_number_in_a_docstring_has_an_entry_that_names_exactly_its_policies():
    cited = {}
    for policy, text in docstrings().items():
        for number in numbers(text):
            cited.setdefault(number, []).append(policy)
    assert cited == {number_of(entry): policies_of(entry) for entry in METHODS.values() if number_of(entry)}


@pytest.mark.parametrize("key", METHODS)
def test_docstrings_name_author_and_year_of_their_entries(key):
    entry = METHODS[key]
    family = plain(entry["author"].partition(",")[0])
    assert key == family.replace(" ", "").replace("-", "") + entry["year"] or key == "hoerner2016"
    for policy in policies_of(entry):
        assert family in plain(docstrings()[policy])
        assert entry["year"] in docstrings()[policy] or f"arXiv:{entry['year'][2:]}" in docstrings()[policy]


@pytest.mark.parametrize("name", ["METHODS", "paper"])
def test_entries_have_author_title_year_and_venue(name):
    found = entries(PAPER / f"{name}.bib")
    for key, entry in found.items():
        assert all(entry.get(field) for field in ("author", "title", "year")), key
        assert {"journal", "booktitle", "school", "howpublished", "publisher"} & set(entry), key
    given = [number_of(entry) for entry in found.values() if number_of(entry)]
    assert len(given) == len(set(given))


def test_every_policy_but_three_is_from_a_paper():
    assert set(docstrings()) - {policy for entry in METHODS.values() for policy in policies_of(entry)} == OWN


def test_the_paper_has_its_sections_and_a_length_that_the_journal_takes():
    header, text = paper()
    assert header.keys() >= {"title", "tags", "authors", "affiliations", "date", "bibliography"}
    assert {str(author["affiliation"]) for author in header["authors"]} <= {
        str(each["index"]) for each in header["affiliations"]
    }
    assert re.findall(r"^# (.+)$", text, re.MULTILINE) == [
        *("Summary", "Statement of need", "State of the field", "What it does", "Research use"),
        *("Acknowledgements", "References"),
    ]
    assert 750 <= len(re.sub(r"^#.*$|!\[[^\]]*\]\([^)]*\)|\[@[^\]]*\]", "", text, flags=re.MULTILINE).split()) <= 1000


def test_the_paper_cites_its_bibliography_and_shows_a_figure_that_exists():
    header, text = paper()
    assert set(re.findall(r"@(\w+)", text)) == set(entries(PAPER / header["bibliography"]))
    ((figure, label),) = [
        (target, re.search(r"\\label\{(.+?)\}", caption)[1])
        for caption, target in re.findall(r"!\[([^\]]*(?:\[[^\]]*\][^\]]*)*)\]\(([^)]*)\)", text)
    ]
    assert (PAPER / figure).is_file()
    assert rf"\autoref{{{label}}}" in text


def test_every_figure_of_the_paper_stands_in_the_results():
    _, text = paper()
    results = " ".join((ROOT / name).read_text("utf-8") for name in ("README.md", "evaluation/site/pages/results.md"))
    used = re.findall(r"\d\.\d{3}|\d+ %(?! and| cov)", " ".join(text.split("# Research use")[1].split()))
    assert len(used) > 5
    assert [number for number in used if number not in results] == []


def paper():
    """The header of the paper, and its text."""
    _, header, text = (PAPER / "paper.md").read_text("utf-8").split("---\n", 2)
    return yaml.safe_load(header), text


def test_zenodo_is_told_what_stands_in_the_citation_and_the_package():
    told = json.loads((ROOT / ".zenodo.json").read_text("utf-8"))
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    for field in ("title", "license", "version", "keywords"):
        assert told[field] == cited[field], field
    assert told["description"] == cited["abstract"]
    assert told["creators"] == cited["authors"] == project["authors"]
    assert told["upload_type"] == cited["type"] == "software"
    assert (told["license"], told["version"]) == (project["license"], project["version"])


def test_listings_name_the_versions_that_are_tested_with_and_more_policies_than_they_say():
    text = (PAPER / "LISTINGS.md").read_text("utf-8")
    pinned = dict(line.split("==") for line in (ROOT / "constraints.txt").read_text().splitlines() if "==" in line)
    badges = dict(re.findall(r"badge/(\w+)-v([\d.]+)-blue", text))
    assert badges == {"Gymnasium": pinned["gymnasium"], "PettingZoo": pinned["pettingzoo"]}
    assert text.count("more than thirty") + text.count("More than thirty") == 2
    assert len(docstrings()) > 30
