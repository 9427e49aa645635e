"""The tests that `make test` leaves to `make test-long`, which continuous integration runs: those that take longest.

    python -P -m pytest -n 2 --dist loadgroup -m "not slow" --durations=0 --durations-min=0.1 > durations.txt
    python -m tests.long_tests durations.txt

writes `long_tests.txt` anew by what pytest measured. A line of it names a test function, or a whole file where the
tests share a fixture that takes long to set up.
"""

import re
import sys
from collections import Counter, defaultdict
from collections.abc import Iterable, Set
from pathlib import Path

LISTED = Path(__file__).with_suffix(".txt")
#: A function is long from so many seconds on, of all its parameters together and of each on average.
ALL_PARAMETERS, EACH_PARAMETER = 1.0, 0.6
#: A file is long if setting up its fixtures takes so many seconds.
FIXTURES = 4.0
MEASURED = re.compile(r"([\d.]+)s (call|setup) +(\S.*)")


def function_of(test: str) -> str:
    """Return the name of a test without its parameters and its group for pytest-xdist."""
    return re.split(r"[\[@]", test, maxsplit=1)[0]


def is_long(test: str, listed: Set[str]) -> bool:
    """Tell whether a test, or the file that it is in, is listed."""
    function = function_of(test)
    return function in listed or function.partition("::")[0] in listed


def read() -> frozenset[str]:
    """Return what is listed."""
    return frozenset(LISTED.read_text(encoding="utf-8").split())


def found(lines: Iterable[str]) -> list[str]:
    """Return the functions and files that are long by the durations that pytest printed, in order."""
    fixtures: defaultdict[str, float] = defaultdict(float)
    seconds: defaultdict[str, float] = defaultdict(float)
    parameters: Counter[str] = Counter()
    for line in lines:
        if measured := MEASURED.match(line):
            duration, part, function = float(measured[1]), measured[2], function_of(measured[3])
            if part == "setup":
                fixtures[function.partition("::")[0]] += duration
            else:
                seconds[function] += duration
                parameters[function] += 1
    files = {file for file, duration in fixtures.items() if duration >= FIXTURES}
    functions = {
        function
        for function, duration in seconds.items()
        if duration >= max(ALL_PARAMETERS, EACH_PARAMETER * parameters[function]) and not is_long(function, files)
    }
    return sorted(files | functions)


if __name__ == "__main__":
    durations = Path(sys.argv[1]).read_text(encoding="utf-8").splitlines()
    LISTED.write_text("".join(f"{name}\n" for name in found(durations)), encoding="utf-8")
