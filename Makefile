# Everything from nothing: Python 3.11 to 3.13 and make are all that is needed.
# A virtual environment is made in .venv once; PYTHON names the interpreter: make test PYTHON=python3.12

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check

# Blender as a Python module, 900 MB, in an environment of its own; the version is that of the stored points.
BLENDER := .venv-blender
BLENDER_PYTHON ?= python3.11

.PHONY: help demo test test-external lint benchmark clean

help:
	@echo "make demo           fit the built-in scan and draw a picture of the result"
	@echo "make test           run all tests"
	@echo "make test-external  compare with Blender (needs Python 3.11, downloads 900 MB once)"
	@echo "make lint           check style, types and the floors of the house"
	@echo "make benchmark      measure, and print the tables of docs/benchmarks.md"
	@echo "make clean          remove the virtual environments and everything that was built"

demo: $(VENV)/subdfit.installed
	$(BIN)/python -m subdfit demo

# A file's tests stay together: they share what its fixtures made.
test: $(VENV)/test.installed
	$(BIN)/python -m pytest --numprocesses auto --maxprocesses 8 --dist loadfile

test-external: $(VENV)/test.installed $(BLENDER)/blender.installed
	SUBDFIT_BLENDER=$(abspath $(subst $(VENV),$(BLENDER),$(BIN)))/python $(BIN)/python -m pytest tests/external

lint: $(VENV)/lint.installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

benchmark: $(VENV)/benchmark.installed
	$(BIN)/python -m benchmarks

$(VENV)/subdfit.installed: pyproject.toml
	@$(PYTHON) -c "import sys; (3, 11) <= sys.version_info[:2] <= (3, 13) or sys.exit('subdfit runs on Python 3.11 to 3.13 and $(PYTHON) is ' + sys.version.split()[0] + '; name another: make PYTHON=python3.12')"
	$(PYTHON) -m venv $(VENV)
	$(INSTALL) --editable .
	@touch $@

# What tests, checks and benchmarks need besides are the extras of pyproject.toml.
$(VENV)/%.installed: $(VENV)/subdfit.installed
	$(INSTALL) --editable ".[$*]"
	@touch $@

$(BLENDER)/blender.installed:
	$(BLENDER_PYTHON) -m venv $(BLENDER)
	$(subst $(VENV),$(BLENDER),$(BIN))/python -m pip install --quiet --disable-pip-version-check bpy==5.0.1
	@touch $@

clean:
	rm -rf $(VENV) $(BLENDER) build dist out .mypy_cache .ruff_cache .pytest_cache .import_linter_cache
	find src tests benchmarks examples -name __pycache__ -type d -prune -exec rm -rf {} +
