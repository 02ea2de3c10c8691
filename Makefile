# SPDX-License-Identifier: GPL-3.0-or-later
# Every target sets up what it needs: a virtual environment with Blender as a Python module.
#   PYTHON=COMMAND   the Python to make it with (3.11 or 3.13; else the first one found)
#   BPY=4.2          the version of Blender in it (else 4.5 for Python 3.11, 5.2 for 3.13)
#   BLENDER=PATH     a Blender program, for `make demo` and the end-to-end tests
VENV ?= .venv$(addprefix -,$(BPY))
LINT_VENV ?= .venv-lint
READERS_VENV ?= .venv-readers
DOCS_VENV ?= .venv-docs
RUN = $(VENV)/bin/python
# Makes environments and runs the checks, also where there is no make.
DEV = python3 scripts/dev.py
export PYTHON BPY BLENDER VENV LINT_VENV

.DEFAULT_GOAL := help
.PHONY: help venv demo test test-all golden readers mqtt bench lint docs pictures zip assets downloads sample clean

help: ## this list
	@awk -F':.*## ' '/^[a-z-]+:.*## / { printf "%-10s%s\n", $$1, $$2 }' Makefile
	@sed -n 's/^#   /          /p' Makefile

demo: ## simulate the sample home and show what its sensors saw
	@$(DEV) demo

test: ## run the quick tests, in minutes (ARGS="-k pir": pytest's options; ARGS="-n 0": in one process)
	@$(DEV) test $(ARGS)

test-all: ## run all tests in this version of Blender
	@$(DEV) test-all $(ARGS)

golden: venv ## write the golden files anew (ARGS="-k help": some of them); say why in the commit
	@ANGEN_GOLDEN=write $(RUN) -m pytest -q tests/blender/test_golden.py tests/pure/test_spelling.py $(ARGS)
	@git status --short tests/golden tests/data/words.txt

readers: ## read the files of all formats with programs that others wrote (800 MB to fetch, once)
	@BPY= $(DEV) venv $(READERS_VENV) readers
	@ANGEN_READERS=1 $(READERS_VENV)/bin/python -m pytest -q tests/readers $(ARGS)

mqtt: venv ## send to a real broker (fetches mosquitto into build/)
	@sh scripts/get_mosquitto.sh build/mosquitto
	@ANGEN_MQTT=1 $(RUN) -m pytest -q tests/mqtt $(ARGS)

bench: venv ## measure speed against error; writes docs/benchmarks.md (ARGS=--quick: a glance)
	@sh scripts/add_engines.sh $(VENV)
	@$(RUN) -m benchmarks $(ARGS)

lint: ## check style and types
	@$(DEV) lint

docs: ## build the docs as a site, with search that works offline, in build/site/
	@BPY= $(DEV) venv $(DOCS_VENV) docs
	@NO_MKDOCS_2_WARNING=1 $(DOCS_VENV)/bin/python -m mkdocs build --strict
	@echo "build/site/index.html"

pictures: ## make the docs' pictures anew in a real Blender's window (BLENDER=PATH; ARGS="timeline": some)
	@sh scripts/pictures/make.sh $(or $(BLENDER),blender) $(ARGS)

zip: ## build the extension for Blender in dist/ (needs Python 3.11 or later, and fetches nothing)
	@$(DEV) zip

assets: venv ## build an asset library of ready sensors, to drag from the Asset Browser, in dist/assets/
	@$(RUN) scripts/build_assets.py dist/assets

downloads: zip assets docs ## pack all that a release offers into dist/
	@$(RUN) scripts/build_downloads.py dist

sample: ## rebuild sample_blends/*.blend (with Blender 4.2, so that every later version opens them)
	@BPY=4.2 $(DEV) venv .venv-4.2 test
	@.venv-4.2/bin/python sample_blends/build_angen.py
	@.venv-4.2/bin/python sample_blends/build_pressure.py
	@.venv-4.2/bin/python sample_blends/build_light.py
	@.venv-4.2/bin/python sample_blends/build_light_control.py
	@.venv-4.2/bin/python sample_blends/build_atelier.py

clean: ## remove what these targets made
	rm -rf .venv* .types build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

venv:
	@$(DEV) venv $(VENV) test
