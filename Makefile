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
LINT = $(LINT_VENV)/bin/python
PYTEST = $(RUN) -m pytest -n auto --maxprocesses 4 --dist worksteal
export PYTHON BPY BLENDER

.DEFAULT_GOAL := help
.PHONY: help venv lint-venv demo test test-all golden readers mqtt bench lint docs pictures zip assets sample clean

help: ## this list
	@sed -n 's/^\([a-z-]*\):.*## /\1\t/p' Makefile | expand -t 10
	@sed -n 's/^#   /          /p' Makefile

demo: venv ## simulate the sample home and show what its sensors saw
	@$(RUN) scripts/demo.py

test: venv ## run the quick tests, in minutes (ARGS="-k pir": pytest's options; ARGS="-n 0": in one process)
	@$(PYTEST) -m "not slow and not measured" $(ARGS)

test-all: venv ## run all tests in this version of Blender
	@$(PYTEST) -m "not measured" $(ARGS)

golden: venv ## write the golden files anew (ARGS="-k help": some of them); say why in the commit
	@ANGEN_GOLDEN=write $(RUN) -m pytest -q tests/blender/test_golden.py tests/pure/test_spelling.py $(ARGS)
	@git status --short tests/golden tests/data/words.txt

readers: ## read the files of all formats with programs that others wrote (800 MB to fetch, once)
	@BPY= sh scripts/make_venv.sh $(READERS_VENV) readers
	@ANGEN_READERS=1 $(READERS_VENV)/bin/python -m pytest -q tests/readers $(ARGS)

mqtt: venv ## replay into a real broker (fetches mosquitto and paho-mqtt into build/)
	@sh scripts/get_mosquitto.sh build/mosquitto
	@[ -d build/mqtt/paho ] || $(RUN) -m pip install -q --disable-pip-version-check --target build/mqtt 'paho-mqtt~=2.1'
	@ANGEN_MQTT=1 PYTHONPATH=build/mqtt $(RUN) -m pytest -q tests/mqtt $(ARGS)

bench: venv ## measure speed against error; writes docs/benchmarks.md (ARGS=--quick: a glance)
	@sh scripts/add_engines.sh $(VENV)
	@$(RUN) -m benchmarks $(ARGS)

lint: lint-venv ## check style and types
	@$(LINT) -m ruff check --output-format concise .
	@$(LINT) -m ruff format --check .
	@sh scripts/check_types.sh $(LINT)

docs: ## build the docs as a site, with search that works offline, in build/site/
	@BPY= sh scripts/make_venv.sh $(DOCS_VENV) docs
	@NO_MKDOCS_2_WARNING=1 $(DOCS_VENV)/bin/python -m mkdocs --quiet build --strict
	@echo "build/site/index.html"

pictures: ## make the docs' pictures anew in a real Blender's window (BLENDER=PATH; ARGS="timeline": some)
	@sh scripts/pictures/make.sh $(or $(BLENDER),blender) $(ARGS)

zip: ## build the extension for Blender in dist/ (needs Python 3.11 or later, and fetches nothing)
	@python=$$(sh scripts/find_python.sh 3.13 3.12 3.11 3.14 2>/dev/null || echo python3); \
	"$$python" scripts/build_zip.py dist

assets: venv ## build an asset library of ready sensors, to drag from the Asset Browser, in dist/assets/
	@$(RUN) scripts/build_assets.py dist/assets

sample: ## rebuild sample_blends/*.blend (with Blender 4.2, so that every later version opens them)
	@BPY=4.2 sh scripts/make_venv.sh .venv-4.2 test
	@.venv-4.2/bin/python sample_blends/build_angen.py
	@.venv-4.2/bin/python sample_blends/build_pressure.py
	@.venv-4.2/bin/python sample_blends/build_light.py
	@.venv-4.2/bin/python sample_blends/build_light_control.py
	@.venv-4.2/bin/python sample_blends/build_atelier.py

clean: ## remove what these targets made
	rm -rf .venv* .types build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

venv:
	@sh scripts/make_venv.sh $(VENV) test

lint-venv:
	@BPY= sh scripts/make_venv.sh $(LINT_VENV) lint
