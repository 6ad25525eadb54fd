# vulnus: what a newcomer needs is Python 3.11+, a C++20 compiler and make; the rest comes from PyPI.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
NATIVE := $(shell find native -type f 2>/dev/null) CMakeLists.txt

.DEFAULT_GOAL := help
.PHONY: help demo demo-short test bench lint docs clean

help:
	@echo "vulnus: from a leg's CT scan to the blood on the floor"
	@echo ""
	@echo "  make demo    shoot a leg and let it bleed: pictures, film, curves, numbers in runs/"
	@echo "  make test    run the tests"
	@echo "  make lint    style, types, import contracts, spelling, equation map"
	@echo "  make bench   measure the solvers"
	@echo "  make docs    build the handbook into docs/_build"
	@echo "  make clean   remove what make built (not your runs)"
	@echo ""
	@echo "The first call makes .venv here and builds the native code (a few minutes)."

$(VENV)/.ready:
	@$(PYTHON) tools/check_toolchain.py
	@echo "making $(VENV)"
	@$(PYTHON) -m venv $(VENV)
	@touch $@

$(VENV)/.build-tools: $(VENV)/.ready constraints.txt
	@echo "installing the build tools"
	@$(PIP) install -c constraints.txt --upgrade pip scikit-build-core nanobind cmake ninja
	@touch $@

$(VENV)/.vulnus: $(VENV)/.build-tools pyproject.toml constraints.txt $(NATIVE)
	@echo "building vulnus and installing what it needs"
	@$(PIP) install -c constraints.txt --no-build-isolation -e ".[render]"
	@touch $@

$(VENV)/.test: $(VENV)/.vulnus
	@echo "installing the test tools"
	@$(PIP) install -c constraints.txt --group test
	@touch $@

$(VENV)/.lint: $(VENV)/.build-tools pyproject.toml constraints.txt
	@echo "installing the lint tools"
	@$(PIP) install -c constraints.txt --group lint
	@touch $@

$(VENV)/.docs: $(VENV)/.vulnus
	@echo "installing the documentation tools"
	@$(PIP) install -c constraints.txt --group docs
	@touch $@

demo: $(VENV)/.vulnus
	$(BIN)/vulnus demo

demo-short: $(VENV)/.vulnus
	rm -rf build/demo-short
	$(BIN)/vulnus run demo_short -o build/demo-short

test: $(VENV)/.test
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadfile tests

bench: $(VENV)/.vulnus
	$(BIN)/python benchmarks/bench_injury.py
	$(BIN)/python benchmarks/bench_hemorrhage.py
	$(BIN)/python benchmarks/bench_circulation.py

lint: $(VENV)/.vulnus $(VENV)/.lint
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/typos
	$(BIN)/python tools/check_guide_paths.py
	$(BIN)/python tools/equation_map.py --check
	$(BIN)/clang-format --dry-run -Werror $$(find native -name '*.cpp' -o -name '*.hpp')
	$(BIN)/lint-imports
	$(BIN)/mypy

docs: $(VENV)/.docs
	$(BIN)/sphinx-build -W --keep-going -q -b html docs docs/_build/html
	@echo "open docs/_build/html/index.html"

clean:
	rm -rf $(VENV) build docs/_build .pytest_cache .mypy_cache .ruff_cache .hypothesis
