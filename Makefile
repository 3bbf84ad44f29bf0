# The two commands: `make demo` (see it work) and `make test` (see it hold).  `make help` lists the rest.
PYTHON ?= python3
BIN := .venv/bin
STAMPS := .venv/.stamps
# Who sits behind a proxy with a certificate of its own has that one in the system's store; a bare system has no store.
CERTIFICATES := $(if $(wildcard /etc/ssl/certs/ca-certificates.crt),--system-certs)
INSTALL := $(BIN)/uv pip install --quiet $(CERTIFICATES) --python $(BIN)/python --compile-bytecode --constraint constraints.txt

.PHONY: venv compiled referees help demo test fuzz lint format bench docs pictures constraints clean

help: ## List the targets
	@sed -n 's/^\([a-z]*\):.*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 14

demo: $(STAMPS)/base ## Simulate a furnished flat, map it and compare the map with the truth, into echoplan-demo/
	@$(BIN)/echoplan demo

# Rewriting the asserts and compiling the package costs each process 8 s wherever byte code is not kept.
test: $(STAMPS)/test $(STAMPS)/compiled ## Run every test
	@PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest -n auto --dist loadfile --max-worker-restart 0

fuzz: $(STAMPS)/test $(STAMPS)/compiled ## Try random input for two minutes; SEED=7 SECONDS=120 to choose
	@$(BIN)/python tests/fuzz/campaign.py $(if $(SEED),--seed $(SEED)) $(if $(SECONDS),--seconds $(SECONDS))

lint: $(STAMPS)/dev ## Linters, formatting, types and the import contracts
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache

format: $(STAMPS)/dev ## Format the code and fix what ruff can fix
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: $(STAMPS)/test ## Print every measured figure that the documents quote; FOLDERS="..." with recordings, too
	@$(BIN)/python benchmarks/run.py $(FOLDERS)

docs: $(STAMPS)/docs ## Build the documentation site; open docs/_build/html/index.html
	@$(BIN)/python -m sphinx -q -W -n --keep-going -d docs/_build/doctrees docs docs/_build/html

pictures: $(STAMPS)/base ## Draw the pictures of the documents
	@$(BIN)/python docs/pictures.py

constraints: $(STAMPS)/tools ## Pin the newest versions that the ranges allow
	$(BIN)/uv pip compile --quiet --universal --no-header --no-annotate --upgrade --all-extras --group dev --group firmware \
	    --python-version 3.11 pyproject.toml --output-file constraints.txt

clean: ## Remove everything that was made
	rm -rf .venv echoplan-demo out docs/_build .pytest_cache .mypy_cache .ruff_cache .hypothesis dist

# A virtual environment needs ensurepip, which Debian and Ubuntu keep in a package of their own.
$(STAMPS)/venv:
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
	    echo "Installing python3-venv (Debian keeps it apart from python3) ..."; \
	    SUDO=$$([ "$$(id -u)" = 0 ] || echo sudo); \
	    $$SUDO apt-get -qq update && $$SUDO apt-get -qq install -y --no-install-recommends python3-venv; }
	@echo "Making .venv ..."
	@$(PYTHON) -m venv .venv
	@mkdir -p $(STAMPS) && touch $@

$(STAMPS)/tools: $(STAMPS)/venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt uv
	@touch $@

$(STAMPS)/base: $(STAMPS)/tools pyproject.toml constraints.txt
	@echo "Installing echoplan ..."
	@$(INSTALL) --editable '.[ros,cad,device,view]'
	@touch $@

$(STAMPS)/docs: $(STAMPS)/base
	@echo "Installing what the documentation site needs ..."
	@$(INSTALL) --group docs
	@touch $@

$(STAMPS)/test: $(STAMPS)/base
	@echo "Installing what the tests need ..."
	@$(INSTALL) --requirements pyproject.toml --extra cluster --extra ros-live --group test --group docs
	@touch $@

# Two workers and the examples would each compile the same for half a minute; one does it before them.
$(STAMPS)/compiled: $(STAMPS)/base $(shell find src -name '*.py')
	@echo "Compiling ..."
	@$(BIN)/python tests/warm_up.py
	@touch $@

# Needs: apt-get install arduino-core-avr g++ libelf-dev chromium fonts-dejavu-core. The simulated Arduino is compiled for
# some minutes, unless its wheel is there.
referees: $(STAMPS)/test ## Install what the tests of the firmware and of the live page need
	@mkdir -p .venv/wheels
	@CFLAGS="-O1 -g0" CXXFLAGS="-O1 -g0" $(INSTALL) --find-links .venv/wheels --requirements pyproject.toml --group firmware --group browser

venv: $(STAMPS)/venv

compiled: $(STAMPS)/compiled

$(STAMPS)/dev: $(STAMPS)/test
	@echo "Installing the linters ..."
	@$(INSTALL) --group dev
	@touch $@
