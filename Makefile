# make compare   set everything up, compare the four families and chance, print the table and the report's place: two minutes
# make compare-full  the same on more episodes and a whole office floor: some five minutes
# make test      set everything up, run the linters and most tests: some five minutes on two cores, once all is set up
# make test-long the longest of those tests that need nothing more: some seven minutes. Continuous integration runs both
# make test-all  all tests that make test leaves out, also trainings with other libraries, clusters, wheel, browser
# make stress    kill a comparison fifty times and see that nothing is lost: some ten minutes
# make soak      fly every policy over many maps, teams and radios and list who freezes, dithers or fails: an hour
# make docs      write the documentation to results/site; a dead link fails. Flies the experiment families with EPISODES=2
#                on each map, once: some four minutes on two cores. EPISODES=30, as published: much longer.
#                With DATA=FOLDER also the reports of the suites on the maps that are cloned there
# make dataset   write the episodes of RESULTS="results/a results/b" to OUT: Parquet, a data card, SHA-256 sums
# make dist      build wheel and sdist in dist/, and try the wheel in a fresh environment
# make browser   have a Chromium for the tests of the report page, where Debian's can be installed

PYTHON ?= python3
VENV ?= .venv
OUT ?= results/$@
EPISODES ?= 2
RUN = $(VENV)/bin
BROWSERS = chromium chromium-browser google-chrome
PYTEST = $(RUN)/python -P -m pytest -n 2 --dist loadgroup --no-loadscope-reorder
APT = DEBIAN_FRONTEND=noninteractive apt-get -qq -o Acquire::Retries=0 -o Acquire::http::Timeout=20

# every process of a test would compile the package's modules to bytecode anew
unexport PYTHONDONTWRITEBYTECODE

# prints the folder of another clone, whose code the environment runs
define OTHER_CLONE
import importlib.metadata as m, json, pathlib, urllib.parse as u
told = [json.loads(d.read_text("direct_url.json") or "{}") for d in m.distributions(name="indoor-explorers")]
homes = [pathlib.Path(u.unquote(u.urlparse(t["url"]).path)) for t in told if t.get("dir_info", {}).get("editable")]
print(*(home for home in homes if home.resolve() != pathlib.Path.cwd().resolve()))
endef
export OTHER_CLONE

.PHONY: compare compare-full test test-long test-all lint warm-up stress soak docs dataset dist browser clean own-venv

compare: $(VENV)/.installed-compare
	$(RUN)/indoor-explorers compare --experiment evaluation/experiments/quick.toml --out $(OUT)

compare-full: $(VENV)/.installed-compare
	$(RUN)/indoor-explorers compare --experiment evaluation/experiments/families.toml --out $(OUT)

test: $(VENV)/.installed-test
	@$(MAKE) --no-print-directory -j 2 warm-up lint  # one core compiles while the other one checks types
	$(PYTEST) -m "not slow and not long"

test-long: $(VENV)/.installed-test warm-up
	$(PYTEST) -m long

test-all: $(VENV)/.installed-test browser warm-up
	$(PYTEST) -m "slow or long"

lint: $(VENV)/.installed-test
	$(RUN)/ruff check .
	$(RUN)/ruff format --check .
	$(RUN)/mypy

warm-up: $(VENV)/.installed-test
	$(RUN)/python -m tests.warm_up

stress: $(VENV)/.installed-test
	$(RUN)/python -P tests/stress_resume.py --kills 50

soak: $(VENV)/.installed-test
	$(RUN)/python -m tests.behaviour.soak

docs: $(VENV)/.installed-test
	INDOOR_EXPLORERS_SITE_EPISODES="$(EPISODES)" INDOOR_EXPLORERS_SITE_DATA="$(DATA)" NO_MKDOCS_2_WARNING=1 $(RUN)/python -P -m mkdocs build --quiet --config-file evaluation/site/mkdocs.yml
	@echo "Documentation: results/site/index.html"

dataset: $(VENV)/.installed-dataset
	@test -n "$(RESULTS)" || { echo 'expected RESULTS="DIR ...", folders written by compare, got none'; exit 2; }
	$(RUN)/python -P -m indoor_explorers.evaluation.exports.dataset $(RESULTS) --out $(OUT)
	@echo "Dataset: $(OUT)/datacard.md"

dist: $(VENV)/.installed-test
	rm -rf dist
	$(RUN)/python -m build --no-isolation > /dev/null
	$(PYTHON) -m venv dist/trial
	dist/trial/bin/python -m pip install --quiet --constraint constraints.txt dist/*.whl
	dist/trial/bin/indoor-explorers demo --out dist/trial/demo

browser:
	@for name in $(BROWSERS); do command -v $$name >/dev/null && exit 0; done; \
	if command -v apt-get >/dev/null && [ "$$(id -u)" = 0 ]; then \
		echo "installing Chromium for the tests of the report page"; \
		$(APT) update >/dev/null && $(APT) install --yes --no-install-recommends \
			chromium fonts-dejavu-core fonts-noto-color-emoji >/dev/null && exit 0; \
	fi; \
	echo "no Chromium ($(BROWSERS)) to be had: the tests of the report page in a browser will be skipped"

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "expected Python 3.11 or newer, got $$($(PYTHON) --version); set PYTHON=..."; exit 2; }
	$(PYTHON) -m venv $(VENV)

own-venv: | $(VENV)/bin/python
	@other=$$($(RUN)/python -P -c "$$OTHER_CLONE") && test -z "$$other" || \
		{ echo "$(VENV) belongs to the clone in $$other, expected one of this folder; set another VENV"; exit 2; }

$(VENV)/.installed-compare: pyproject.toml constraints.txt | own-venv
	$(RUN)/python -m pip install --quiet --constraint constraints.txt --editable .
	touch $@

$(VENV)/.installed-test: pyproject.toml constraints.txt | own-venv
	$(RUN)/python -m pip install --quiet --constraint constraints.txt --editable ".[dev]"
	touch $@ $(VENV)/.installed-compare

$(VENV)/.installed-dataset: pyproject.toml constraints.txt | own-venv
	$(RUN)/python -m pip install --quiet --constraint constraints.txt --editable ".[dataset]"
	touch $@

clean:
	rm -rf $(VENV) build dist *.egg-info results
