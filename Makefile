# Two commands do everything: `make study` and `make test`. Either sets up .venv first, once.
PYTHON ?= python3
BIN := .venv/bin
READY := .venv/.ready
# uv installs in a third of pip's time, but knows nothing of pip's settings: not where they name an index.
QUICKLY := ! $(BIN)/pip config list | grep -q '[.]index-url' && $(BIN)/uv pip install -q --compile-bytecode --python .venv

.PHONY: study study-full paper test check bench docs cluster clients release-check setup
.DEFAULT_GOAL := study

study: setup  ## run the main job; options in ARGS, e.g. make study ARGS="--tracks DIR"
	$(BIN)/hazbot study --config configs/study.yaml $(ARGS)

study-full: setup  ## tune, train and compare everybody; resumable
	$(BIN)/hazbot study --config configs/study_full.yaml --out results/study-full $(ARGS)

paper: setup  ## run every experiment of the published paper again
	$(BIN)/hazbot paper $(ARGS)

test: setup  ## run all tests
	$(BIN)/python -m pytest $(ARGS)

check: setup  ## lint, formatting, types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: setup  ## steps per second, beside Gymnasium's CartPole
	$(BIN)/hazbot bench $(ARGS)

docs: setup  ## build the documentation site into docs/_build/html; a warning is an error
	$(BIN)/python -m sphinx -W --keep-going -q -E -b html -d docs/_build/doctrees docs docs/_build/html
	@echo "Documentation: docs/_build/html/index.html"

cluster:  ## run the tests on a real Ray cluster, in a .venv-cluster: RLlib asks for an older Gymnasium
	@test -x .venv-cluster/bin/python || $(PYTHON) -m venv .venv-cluster
	@grep -v '^gymnasium==' constraints.txt > .venv-cluster/constraints.txt
	@.venv-cluster/bin/pip install -qq -c .venv-cluster/constraints.txt torch
	@.venv-cluster/bin/pip install -qq -c .venv-cluster/constraints.txt -e ".[study,train,cluster]" "ray[rllib]" pytest hypothesis
	.venv-cluster/bin/python -m pytest -v -s -m slow -k "cluster or rllib" tests/evaluation/test_ray_cluster.py tests/test_scripts.py $(ARGS)

release-check:  ## build wheel and sdist, check them, and use them in clean environments (minutes)
	$(PYTHON) .ci/release_check.py $(ARGS)

CLIENTS := $(basename $(notdir $(wildcard tests/clients/*.txt)))

clients: $(CLIENTS:%=client-%)  ## run the tests with other libraries, each in an environment of its own

client-%: tests/clients/%.txt  ## one of them, e.g. make client-skrl; what its file pins stands above constraints.txt
	@test -x .venv-clients/$*/bin/python || $(PYTHON) -m venv .venv-clients/$*
	@sed 's/[^A-Za-z0-9_-].*//; s/.*/^&==/' $< | grep -vif - constraints.txt > .venv-clients/$*/constraints.txt
	@.venv-clients/$*/bin/pip install -qq -c .venv-clients/$*/constraints.txt torch
	@.venv-clients/$*/bin/pip install -qq -c .venv-clients/$*/constraints.txt -r $< -e ".[train]" pytest hypothesis
	.venv-clients/$*/bin/python -m pytest -v -m clients -k $* tests/clients tests/docs/test_snippets.py tests/test_scripts.py $(ARGS)

setup: $(READY)

$(READY): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "hazbot_gym needs Python 3.11 or newer, e.g. make PYTHON=python3.11"; exit 1; }
	@echo "Setting up .venv (a few minutes, once) ..."
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv
	@$(BIN)/pip install -qq -c constraints.txt torch uv
	@$(QUICKLY) -c constraints.txt -e ".[all,dev]" || $(BIN)/pip install -qq -c constraints.txt -e ".[all,dev]"
	@touch $@
