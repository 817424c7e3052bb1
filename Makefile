# Everything is set up in .venv by itself; a bare `make` lists what there is.
# Bullet has a wheel for 3.11 alone. Each is tried by running it: a name on the path may be no Python.
PYTHON ?= $(shell for name in python3.11 python3.13 python3.12; do \
	$$name -c 'import venv' >/dev/null 2>&1 && echo $$name && break; done)
BIN := .venv/bin
VERSION := $(shell $(PYTHON) -c 'import sys; print("%d.%d" % sys.version_info[:2])')
JUDGING := .venv/.judging
LINKS := .src/.linked
READY := .venv/.ready
SITE := .venv/.site
# What a lock file names, and nothing else, each file with its hash; then this clone.
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check
CLONE := $(INSTALL) --no-deps --no-build-isolation --editable .
COMPILE := $(BIN)/uv pip compile --generate-hashes --quiet --python-platform x86_64-manylinux_2_36 \
	--no-annotate --custom-compile-command 'make lock'
# Both processes of a run keep whole files: what several tests of a file read is made once. Files
# come in the order of tests/conftest.py, long ones first, not by how many tests they have.
TEST := $(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder

# Tests start many processes, each of which would compile all sources anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help study test test-deep fuzz lint types lock bench engines verify extremes properties benchmark planar lists choosing packers accuracy uncertain tuning learned replication cascade session scale precision transport scope sensitivity table real docs site clean pages pin

help: ## list these targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-10s %s\n", $$1, $$2}'

$(JUDGING): pyproject.toml setup.py locks/judging-$(VERSION).txt
	test -d .venv || $(PYTHON) -m venv .venv
	$(INSTALL) --require-hashes -r locks/judging-$(VERSION).txt
	$(CLONE)
	@touch $@

# A new child of harness changes the time of the folder.
$(LINKS): $(JUDGING) harness
	$(BIN)/python setup.py --quiet links
	@touch $@

$(READY): $(JUDGING) locks/all-$(VERSION).txt | $(LINKS)
	$(INSTALL) --require-hashes -r locks/all-$(VERSION).txt
	@touch $@

$(SITE): $(READY) locks/site-$(VERSION).txt
	$(INSTALL) --require-hashes -r locks/site-$(VERSION).txt
	@touch $@

study: $(JUDGING) $(LINKS) ## run the embedded study and write its report
	@$(BIN)/steadyload study run embedded --output runs/embedded
	@$(BIN)/steadyload report runs/embedded

test: $(READY) ## run the tests of every module (five minutes on two cores, once compiled); PERTURB=SEED moves starts by rounding
	@$(BIN)/steadyload warm-up
	$(TEST) -m 'not deep' $(if $(PERTURB),--perturb $(PERTURB))

N ?= 1000000
SEED ?= 0

fuzz: $(READY) ## read N mutated files of every format, from SEED; PUBLISH=1 puts the figures on docs/reliability.md; Ctrl-C ends it
	$(BIN)/python tests/fuzz/fuzz.py $(N) $(SEED) $(if $(PUBLISH),--publish)

test-deep: $(READY) ## run the tests that take minutes, and those of optional engines
	@$(BIN)/steadyload warm-up
	$(TEST) -m deep $(if $(PERTURB),--perturb $(PERTURB))

lint: $(READY) ## check style
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY) ## check types
	$(BIN)/mypy

lock: $(READY) ## lock what is installed anew (see docs/installing.md)
	$(COMPILE) pyproject.toml --group build --output-file locks/judging-$(VERSION).txt
	$(COMPILE) pyproject.toml --group build --all-extras --output-file locks/all-$(VERSION).txt
	$(COMPILE) --group site --constraints locks/all-$(VERSION).txt --output-file locks/site-$(VERSION).txt

PALLETS ?= $(wildcard ../shared/data/pallets/pallets.json)

bench: $(READY) ## measure what a judgement costs, beside earlier versions (minutes); PALLETS=FILE for other layouts
	$(BIN)/steadyload bench $(if $(PALLETS),--layouts $(PALLETS)) --output runs/bench

engines: $(READY) ## remake the published comparison of engines (a quarter of an hour)
	$(BIN)/steadyload pages remake --judge engines

verify: $(READY) ## hold engines against mechanics and the reference against itself (half an hour)
	$(BIN)/steadyload pages remake --judge closed_forms convergence

extremes: $(READY) ## take engines to their limits, remake envelopes and page (a quarter of an hour); goes on
	$(BIN)/steadyload pages remake --judge extremes

properties: $(READY) ## remake the page of property tests (an hour of CPU time)
	$(BIN)/steadyload pages remake --judge properties

benchmark: $(READY) ## remake the labelled set (hours) and its page; goes on where it was
	test -e runs/benchmark/manifest.json || $(BIN)/steadyload benchmark build -o runs/benchmark
	$(BIN)/steadyload benchmark label runs/benchmark
	$(BIN)/steadyload benchmark page runs/benchmark -o runs/benchmark

planar: $(READY) ## remake the planar labelled set (a quarter of an hour); goes on where it was
	test -e runs/planar/manifest.json || $(BIN)/steadyload benchmark build --planar -o runs/planar
	$(BIN)/steadyload benchmark label runs/planar --judges none

lists: $(READY) ## remake the labelled set of many item lists (two hours); goes on where it was
	test -e runs/lists/manifest.json || $(BIN)/steadyload benchmark build --lists -o runs/lists
	$(BIN)/steadyload benchmark label runs/lists --judges none
	$(BIN)/steadyload benchmark label runs/lists --question stands

choosing: $(READY) ## remake the labelled set that searches and cascades choose on (an hour); goes on where it was
	test -e runs/choosing/manifest.json || $(BIN)/steadyload benchmark build --choosing -o runs/choosing
	$(BIN)/steadyload benchmark label runs/choosing --judges none
	$(BIN)/steadyload benchmark label runs/choosing --question stands

packers: $(READY) ## remake the page of packers' plans from the labels of the set of real size (seconds)
	$(BIN)/steadyload pages remake --judge packers

accuracy: $(READY) ## remake the accuracies on the whole test split (ten minutes)
	$(BIN)/steadyload pages remake --judge accuracy

uncertain: $(READY) ## remake the page of how sure verdicts are (a quarter of an hour); goes on where it was
	$(BIN)/steadyload pages remake --judge uncertain

tuning: $(READY) ## remake the page of tuning from its searches, on 450 cases (a quarter of an hour); goes on
	$(BIN)/steadyload pages remake --judge tuning

learned: $(READY) ## train what the plan of learners asks for and remake their page (hours); goes on
	$(BIN)/steadyload pages remake --judge learned

replication: $(READY) ## remake the page of the paper's experiment (six hours of CPU time, of trainings); goes on
	$(BIN)/steadyload pages remake --judge replication

cascade: $(READY) ## hold the cascade against others and remake its page (ten minutes); goes on
	$(BIN)/steadyload pages remake --judge cascade

session: $(READY) ## remake the page of loading sessions (a quarter of an hour)
	$(BIN)/steadyload pages remake --judge session

scale: $(READY) ## measure what a study of a million rows needs (a quarter of an hour)
	$(BIN)/steadyload pages remake --judge scale

precision: $(READY) ## remake the page of single and double precision (a quarter of an hour); goes on
	$(BIN)/steadyload pages remake --judge precision

transport: $(READY) ## remake the page of what loads hold on the road (minutes, with the rows that are kept; three hours without)
	$(BIN)/steadyload pages remake --judge transport

scope: $(READY) ## remake the page of simulations of only what a step changes (an hour); goes on
	$(BIN)/steadyload pages remake --judge scope

table: $(READY) ## judge and time all methods on 900 cases of many item lists, for the pages of Table 5 (an hour and a half); goes on
	$(BIN)/steadyload pages remake --judge table5 table5_stands

sensitivity: $(READY) ## remake the page of conclusions under other rules (an hour); goes on
	$(BIN)/steadyload pages remake --judge sensitivity

real: $(READY) ## judge layouts of 25 to 150 boxes by all methods, for their page (hours, in one process for the times); goes on
	$(BIN)/steadyload pages remake --judge real

pages: $(READY) ## remake all published pages and their index (days; goes on); `steadyload pages list` names them
	$(BIN)/steadyload pages remake --judge --keep

TO ?= runs/pin

pin: $(READY) ## remake all published pages from kept rows into TO=FOLDER, to compare them after a change (six minutes of CPU time)
	$(BIN)/python tests/pinning/pin.py record $(TO)

docs: $(READY) ## remake the table of engines and the index of published pages
	$(BIN)/steadyload engines --markdown > docs/engines.md
	$(BIN)/steadyload pages index

site: $(SITE) ## build a static site of docs, pages and API in runs/site/html (two minutes)
	rm -rf runs/site && mkdir -p runs/site/source
	cp -r --parents -t runs/site/source README.md CHANGELOG.md CITATION.cff LICENSE docs reports/published \
		harness/layouts/benchmark/THIRD-PARTY.md reports/viewer/three_js.py
	$(BIN)/python -m sphinx --quiet --fail-on-warning --keep-going -c docs -d runs/site/doctrees \
		runs/site/source runs/site/html

clean: ## remove the virtual environment, caches and runs
	rm -rf .venv .src runs .pytest_cache .ruff_cache .mypy_cache .hypothesis
