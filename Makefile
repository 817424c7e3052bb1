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
# Both processes of a run keep whole files: what several tests of a file read is made once.
TEST := $(BIN)/python -m pytest -n 2 --dist loadfile

# Tests start many processes, each of which would compile all sources anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help build study test test-deep fuzz mutants lint types lock bench benchmark planar lists choosing docs site clean pages pin

help: ## list these targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-10s %s\n", $$1, $$2}'

$(JUDGING): pyproject.toml setup.py backend.py locks/judging-$(VERSION).txt
	test -d .venv || $(PYTHON) -m venv .venv
	$(INSTALL) --require-hashes -r locks/judging-$(VERSION).txt
	@$(BIN)/python backend.py || { echo "There is no C compiler: installing ziglang."; \
		$(INSTALL) --require-hashes -r locks/compiler.txt; }
	$(CLONE)
	@touch $@

# A new child of harness changes the time of the folder.
$(LINKS): $(JUDGING) harness
	$(BIN)/python setup.py --quiet links
	@touch $@

$(READY): $(JUDGING) locks/all-$(VERSION).txt | $(LINKS) build
	$(INSTALL) --require-hashes -r locks/all-$(VERSION).txt
	@touch $@

$(SITE): $(READY) locks/site-$(VERSION).txt
	$(INSTALL) --require-hashes -r locks/site-$(VERSION).txt
	@touch $@

build: $(JUDGING) ## build the C library, where a source of it has changed; DEBUG=1 anew, for gdb
	@$(BIN)/python harness/core/building.py $(if $(DEBUG),-O0 -g)

study: $(JUDGING) $(LINKS) build ## run the embedded study and write its report
	@$(BIN)/steadyload study run embedded --output runs/embedded
	@$(BIN)/steadyload study report runs/embedded

test: $(READY) ## run the tests of every module (minutes on two cores, once compiled); PERTURB=SEED moves starts by rounding
	@$(BIN)/steadyload warm-up
	$(TEST) -m 'not deep' $(if $(PERTURB),--perturb $(PERTURB))

N ?= 1000000
SEED ?= 0

fuzz: $(READY) ## read N mutated files of every format, from SEED; PUBLISH=1 puts the figures on docs/wrong_input.md; Ctrl-C ends it
	$(BIN)/python tests/fuzz/fuzz.py $(N) $(SEED) $(if $(PUBLISH),--publish)

test-deep: $(READY) ## run the tests that take minutes, and those of optional engines; SHARE=K/N the K-th of N shares
	@$(BIN)/steadyload warm-up
	$(TEST) -m deep $(if $(PERTURB),--perturb $(PERTURB)) $(if $(SHARE),--share $(SHARE))

COUNT ?= 100

mutants: $(READY) ## plant COUNT one-line faults by SEED, and count those that the tests of their rooms catch; ROOM=FOLDER of one alone
	$(BIN)/python tests/mutants/mutants.py --count $(COUNT) --seed $(SEED) $(if $(ROOM),--room $(ROOM))

lint: $(READY) ## check style
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY) ## check types
	$(BIN)/mypy

lock: $(READY) ## lock what is installed anew (see docs/installing.md)
	$(COMPILE) pyproject.toml --group build --output-file locks/judging-$(VERSION).txt
	$(COMPILE) pyproject.toml --group build --all-extras --output-file locks/all-$(VERSION).txt
	$(COMPILE) --group compiler --output-file locks/compiler.txt
	$(COMPILE) --group site --constraints locks/all-$(VERSION).txt --output-file locks/site-$(VERSION).txt

PALLETS ?= $(wildcard ../shared/data/pallets/pallets.json)

bench: $(READY) ## measure what a judgement costs (minutes); PALLETS=FILE for other layouts
	$(BIN)/steadyload study speed $(if $(PALLETS),--layouts $(PALLETS))

benchmark: $(READY) ## remake the labelled set (hours) and its page; goes on where it was
	test -e runs/benchmark/manifest.json || $(BIN)/steadyload benchmark build -o runs/benchmark
	$(BIN)/steadyload benchmark label runs/benchmark
	$(BIN)/steadyload study benchmark runs/benchmark -o runs/benchmark

planar: $(READY) ## remake the planar labelled set (a quarter of an hour); goes on where it was
	test -e runs/planar/manifest.json || $(BIN)/steadyload benchmark build --planar -o runs/planar
	$(BIN)/steadyload benchmark label runs/planar --judges none

lists: $(READY) ## remake the labelled set of many item lists (four hours); goes on where it was
	test -e runs/lists/manifest.json || $(BIN)/steadyload benchmark build --lists -o runs/lists
	$(BIN)/steadyload benchmark label runs/lists --judges none
	$(BIN)/steadyload benchmark label runs/lists --question stands
	$(BIN)/steadyload benchmark judge runs/lists --limit 100
	$(BIN)/steadyload benchmark judge runs/lists --limit 70 --question stands

choosing: $(READY) ## remake the labelled set that searches and cascades choose on (an hour); goes on where it was
	test -e runs/choosing/manifest.json || $(BIN)/steadyload benchmark build --choosing -o runs/choosing
	$(BIN)/steadyload benchmark label runs/choosing --judges none
	$(BIN)/steadyload benchmark label runs/choosing --question stands

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
		reports/rows/README.md \
		harness/layouts/benchmark/THIRD-PARTY.md reports/viewer/three_js.py
	$(BIN)/python -m sphinx --quiet --fail-on-warning --keep-going -c docs -d runs/site/doctrees \
		runs/site/source runs/site/html

clean: ## remove the virtual environment, caches and runs
	rm -rf .venv .src harness/core/lib runs .pytest_cache .ruff_cache .mypy_cache .hypothesis
