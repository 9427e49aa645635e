"""An error is one printable line, whatever stands in it."""

import pickle

import pytest

from indoor_explorers.env.errors import InputError, RunError


@pytest.mark.parametrize("kind", [InputError, RunError])
def test_a_message_is_one_printable_line(kind):
    message = str(kind(f"maps/a\nb\x1b[31m\udcff/{'x' * 5000}.png: expected a file; correct the path"))
    assert message.startswith(r"maps/a b\x1b[31m\udcff/xxx")
    assert message.endswith("xxx.png: expected a file; correct the path")
    assert len(message) < 400
    assert str(pickle.loads(pickle.dumps(kind(message)))) == message
