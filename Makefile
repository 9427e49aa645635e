# make compare   set everything up, compare the four families and chance, print the table and the report's place
# make test      set everything up, run the linters and the test suite
# make stress    kill a comparison fifty times and see that nothing is lost: some ten minutes

PYTHON ?= python3
VENV ?= .venv
OUT ?= results/compare
RUN = $(VENV)/bin

.PHONY: compare test stress clean

compare: $(VENV)/.installed-compare
	$(RUN)/indoor-explorers compare --experiment evaluation/experiments/families.toml --out $(OUT)

test: $(VENV)/.installed-test
	$(RUN)/ruff check .
	$(RUN)/ruff format --check .
	$(RUN)/mypy
	$(RUN)/python -P -m pytest -n 2

stress: $(VENV)/.installed-test
	$(RUN)/python -P tests/stress_resume.py --kills 50

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "expected Python 3.11 or newer, got $$($(PYTHON) --version); set PYTHON=..."; exit 2; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed-compare: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(RUN)/python -m pip install --quiet --constraint constraints.txt --editable .
	touch $@

$(VENV)/.installed-test: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(RUN)/python -m pip install --quiet --constraint constraints.txt --editable ".[dev]"
	touch $@ $(VENV)/.installed-compare

clean:
	rm -rf $(VENV) build dist *.egg-info results
