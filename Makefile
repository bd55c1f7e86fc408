# Two commands from a clean clone: `make demo` and `make test`. Both make .venv on first use.
# PYTHON=/path/to/python3.12 chooses the interpreter (3.11 or newer).
PYTHON ?= $(shell for p in python3.13 python3.12 python3.11 python3 python; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 && { echo $$p; break; }; done)
VENV ?= .venv
BIN = $(VENV)/bin
PIP = $(BIN)/python -m pip --disable-pip-version-check
LOCKED = install --quiet --require-hashes --only-binary :all:
WORKERS ?= 2
# byte-code is kept: without it each process would compile all that it imports, the tests half a minute in each worker
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo dist docs schemas linkcheck limits readme-picture test test-all test-docs test-long test-browser test-kernels bench coverage practice rates calibration campaigns batch-many faults fuzz fingerprint lint lock example clean
demo: $(VENV)/run.stamp
	$(BIN)/python -P -m stiffcal demo
	@echo "the report: demo/report.pdf"

# the quick tests, in minutes; what takes longer than two seconds of processor time is listed, and belongs to the long ones
PYTEST = $(BIN)/python -m pytest -q -n $(WORKERS) --dist worksteal
test: $(VENV)/test.stamp
	$(PYTEST) -m "not long and not browser and not docs"

# whole campaigns, kills at random points, hidden robots: the tests marked `long`
test-long: $(VENV)/test.stamp
	$(PYTEST) -m "long and not practice and not browser and not docs"

# all but those of `practice` in one go, those of the documentation and in a browser included: each process collects once
test-all: $(VENV)/docs.stamp $(VENV)/browser.stamp
	$(PYTEST) -m "not practice"

# the page of `view` in a browser; needs Debian's chromium (apt-get install chromium), or CHROMIUM=/path/to/chromium
test-browser: $(VENV)/browser.stamp
	$(BIN)/python -m pytest -q -rs -m browser tests/view

# the documentation: build/docs/html/index.html. Warnings are errors; the build uses no network.
SPHINX = $(BIN)/python -P -m sphinx -W --keep-going -q -d build/docs/doctrees
docs: $(VENV)/docs.stamp
	$(SPHINX) -b html docs build/docs/html
	@echo "the documentation: build/docs/html/index.html"

# the picture of README, docs/view.png: the page of `view` for a bundled campaign; needs a browser as test-browser does
readme-picture: $(VENV)/browser.stamp
	$(BIN)/python -m docs.readme_picture

# the links that lead out of the documentation; needs a network
linkcheck: $(VENV)/docs.stamp
	$(SPHINX) -b linkcheck docs build/docs/links

# builds the documentation, runs the commands on its pages, compares their output with what the pages print, and opens
# every page in a browser
test-docs: $(VENV)/docs.stamp $(VENV)/browser.stamp
	$(PYTEST) -m docs tests/docs

# the tests that judge numbers, under the BLAS kernels of several processors; KERNELS=--others leaves out this one's own
KERNELS ?=
test-kernels: $(VENV)/test.stamp
	$(BIN)/python -m tests.kernels $(KERNELS) --workers $(WORKERS)

bench: $(VENV)/test.stamp
	$(BIN)/python -m tests.benchmarks

# 95 % intervals against the truth, over simulated campaigns whose robot is MuJoCo; takes minutes
coverage: $(VENV)/test.stamp
	$(BIN)/python -m tests.benchmarks.coverage

# the campaigns whose truth is known (campaigns/hidden, joints, absolute): what is named, is it right, error before, after;
# then the tests that repeat over more campaigns, seeds and sizes what others show: marked `practice`, not in `make test-all`
practice: $(VENV)/test.stamp
	$(BIN)/python -m tests.rates.practice
	$(PYTEST) -m practice

# fresh campaigns from a seed and how often the right effect is named: `make rates SEED=7`, quicker with COUNT=10
SEED ?= 1
COUNT ?= 0
rates: $(VENV)/test.stamp
	$(BIN)/python -m tests.rates --seed $(SEED) --count $(COUNT) --workers $(WORKERS) --verbose

# the field mix: campaigns in the proportions of laboratories, judged as `diagnose` does; kept in build/calibration, so
# that a second call goes on
JUDGE ?= evidence
calibration: $(VENV)/test.stamp
	$(BIN)/python -m tests.calibration $(JUDGE) --seed $(SEED) $(if $(filter-out 0,$(COUNT)),--count $(COUNT)) --workers $(WORKERS)

# how answers of the bundled logs move when the numbers that decide in their reduction are varied by a fifth; writes
# docs/reference/limits.md: some ten minutes of a processor; a call that was ended goes on (build/limits.jsonl)
limits: $(VENV)/test.stamp
	$(BIN)/python -m tests.limits --workers $(WORKERS)

# what CI holds campaigns/ to: all of them in one batch; build/ci keeps the stores, so that the next call is quick
campaigns: $(VENV)/run.stamp
	$(BIN)/python -P -m stiffcal simulate build/ci/irb4400 --from campaigns/irb4400 --json >/dev/null
	$(BIN)/python -P -m stiffcal batch campaigns/hidden build/ci/irb4400 --thresholds campaigns/thresholds.toml \
		--store build/ci/stores --reports build/ci/reports --junit build/ci/junit.xml --markdown build/ci/summary.md

# two hundred small campaigns with reports in one batch, some broken, killed in the middle and called again
batch-many: $(VENV)/test.stamp
	$(BIN)/python -m tests.batch_many

# faults at random points of every command that writes: kills, full disks, revoked rights, truncated files
FAULTS ?= 400
faults: $(VENV)/test.stamp
	$(BIN)/python -m tests.faults --tries $(FAULTS) --seed $(SEED)

# spoilt inputs for every log format and TOML file; quicker with COUNT=500
fuzz: $(VENV)/test.stamp
	$(BIN)/python -m tests.fuzz --seed $(SEED) --count $(if $(filter-out 0,$(COUNT)),$(COUNT),10000)

# after a change of numbers on purpose: raise REVISION in stiffcal/revision.py, then write some answers anew
fingerprint: $(VENV)/test.stamp
	$(BIN)/python -P -m tests.fingerprint

lint: $(VENV)/test.stamp
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# the JSON Schemas of answers, tables and TOML files, after a change of fields
schemas: $(VENV)/run.stamp
	for part in schemas.documents schemas.tables campaign.schemas simulation.schema; do $(BIN)/python -P -m stiffcal.$$part schemas || exit 1; done

# wheel and sdist of the last commit's date: the same commit gives the same bytes. Checked where twine is installed.
dist: $(VENV)/run.stamp
	rm -rf dist && mkdir dist
	export SOURCE_DATE_EPOCH=$$(git log -1 --format=%ct); for kind in wheel sdist; do \
		$(BIN)/python -P -c "from flit_core.buildapi import build_$$kind as b; print('dist/' + b('dist'))" || exit 1; done
	@if $(BIN)/python -P -c 'import twine' 2>/dev/null; then $(BIN)/python -P -m twine check --strict dist/*; \
		else echo "twine is not installed: the metadata are not checked"; fi

# rewrites requirements/ from pyproject.toml; needs uv on the path (or UV=/path/to/uv)
UV ?= uv
COMPILE = $(UV) pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-header \
	--only-binary :all: --no-emit-index-url --no-emit-find-links --no-annotate pyproject.toml --group build
lock:
	$(COMPILE) --group test -o requirements/test.txt
	$(COMPILE) -c requirements/test.txt -o requirements/run.txt
	$(COMPILE) --group browser -c requirements/test.txt -o requirements/browser.txt
	$(COMPILE) --group docs -c requirements/test.txt -o requirements/docs.txt

# the example that `stiffcal demo` copies; installed packages have no campaigns/
example:
	cd campaigns/demo && cp README.md campaign.toml model.toml robot.toml simulate.toml ../../stiffcal/commands/example/

clean:
	rm -rf $(VENV) demo build dist

$(VENV)/bin/python:
	@test -n "$(PYTHON)" || { echo "no Python 3.11 or newer found; say PYTHON=/path/to/python"; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/run.stamp: requirements/run.txt pyproject.toml | $(VENV)/bin/python
	$(PIP) $(LOCKED) -r requirements/run.txt
	$(PIP) install --quiet --no-deps --no-build-isolation -e .
	@touch $@

$(VENV)/browser.stamp: requirements/browser.txt $(VENV)/test.stamp
	$(PIP) $(LOCKED) -r requirements/browser.txt
	@touch $@

$(VENV)/docs.stamp: requirements/docs.txt $(VENV)/run.stamp
	$(PIP) $(LOCKED) -r requirements/docs.txt
	@touch $@

# all of them at once, for CI: two calls next to each other, as pip unpacks on one core. A lock file lists all that is
# needed, so that no call looks for what the other one installs.
$(VENV)/ci.stamp: requirements/test.txt requirements/browser.txt requirements/docs.txt pyproject.toml | $(VENV)/bin/python
	awk 'FNR == NR { if (/==/) seen[$$1]; next } /==/ { new = !($$1 in seen); seen[$$1] } new' \
		requirements/run.txt requirements/test.txt requirements/browser.txt requirements/docs.txt >$(VENV)/others.txt
	$(PIP) $(LOCKED) --no-deps -r $(VENV)/others.txt & others=$$!; \
		$(PIP) $(LOCKED) --no-deps -r requirements/run.txt && wait $$others
	$(PIP) install --quiet --no-deps --no-build-isolation -e .
	@touch $(VENV)/run.stamp $(VENV)/test.stamp $(VENV)/browser.stamp $(VENV)/docs.stamp $@

# test.txt holds run.txt
$(VENV)/test.stamp: requirements/test.txt $(VENV)/run.stamp
	$(PIP) $(LOCKED) -r requirements/test.txt
	@touch $@
