"""What is cited is listed and what is listed is cited: papers of the policies, and those of the project's own paper."""

import pytest

from tests.bibliography import docstrings, entries, numbers, plain
from tests.documents import ROOT

PAPER = ROOT / "evaluation" / "paper"
#: Policies whose method is from no paper: chance, and a rule of this project.
OWN = {"random", "tours"}
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


def test_every_policy_but_two_is_from_a_paper():
    assert set(docstrings()) - {policy for entry in METHODS.values() for policy in policies_of(entry)} == OWN
