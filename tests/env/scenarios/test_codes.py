"""The names of a scenario's choices and the codes of compiled code are the same choices."""

from typing import get_args

import pytest

from indoor_explorers.env.scenarios.codes import RadioModel, RadioModelName, StuckRule, StuckRuleName


@pytest.mark.parametrize(("names", "codes"), [(RadioModelName, RadioModel), (StuckRuleName, StuckRule)])
def test_every_name_has_a_code_and_every_code_a_name(names, codes):
    assert [codes.named(name) for name in get_args(names)] == [code for code in codes if code.name != "CUSTOM"]
    assert list(codes) == list(range(len(codes)))
