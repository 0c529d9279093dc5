# Everything is installed into .venv; only a missing python3-venv is installed outside of it, by root.
.DEFAULT_GOAL := help
.NOTPARALLEL:
.DELETE_ON_ERROR:
.PHONY: help setup setup-test demo test corpus lint format bench pythons fuzz coverage lock clean

# A sourced ROS installation must not mix with the ROS of .venv.
unexport PYTHONPATH PYTHONHOME LD_LIBRARY_PATH _ROS_WHEELS_BOOTSTRAP_COMPLETE VIRTUAL_ENV
export AMENT_PREFIX_PATH := $(CURDIR)/.venv

# The name of a stamp holds the content that it was made from, so that a change makes it anew.
# Each installation takes the older stamps away first: one that was broken off starts afresh.
sum = $(shell { $(1); } 2>/dev/null | cksum | cut -d ' ' -f 1)
RUNTIME := .venv/runtime-$(call sum,cat requirements.txt)
TEST := .venv/test-$(call sum,cat requirements.txt requirements-test.txt)
PROJECT := .venv/project-$(call sum,ls launch config bags; cat setup.* pyproject.toml \
	package.xml hijack_detect/__init__.py hijack_detect/nodes/__init__.py \
	hijack_detect/monitor/parts.py)

PIP := .venv/bin/python -m pip --disable-pip-version-check --no-input
# The lock is complete: nothing is left to resolve. Older versions of pip refuse a requirement with
# an extra (coverage[toml]) as soon as a newer release than the pinned one exists.
FROM_LOCK := $(PIP) install --quiet --no-deps --require-hashes --use-pep517

help: ## Say what can be made.
	@sed -n 's/^\([a-z-]*\):.*## /  make \1\t/p' Makefile | expand -t 20

setup: $(RUNTIME) $(PROJECT) ## Install the package and what it needs into .venv.

setup-test: $(RUNTIME) $(TEST) $(PROJECT) ## The same, and the tools of the tests.

demo: setup ## Replay a spoofed flight and show the alert.
	@.venv/bin/hijack-detect demo

test: lint ## Check style and types, then run all tests.
	@.venv/bin/python -m pytest -n logical --dist worksteal

corpus: setup-test ## Hold the alerts on all recorded flights of ../shared (several minutes).
	@HIJACK_CORPUS=all .venv/bin/python -m pytest -n logical --dist worksteal \
		test/evaluation/scores/test_recorded_flights.py

lint: setup-test ## Check style and types.
	@.venv/bin/ruff check .
	@.venv/bin/ruff format --check .
	@.venv/bin/mypy

format: setup-test ## Bring the sources into the form that lint checks.
	@.venv/bin/ruff check --quiet --fix . || true
	@.venv/bin/ruff format .

bench: setup-test ## Measure how fast the monitor is, offline and live (a quarter of an hour).
	@.venv/bin/python benchmarks/bench.py build/bench

pythons: setup-test ## Say whether Python 3.10 to 3.13 give the same bits.
	@.venv/bin/python stress/transcripts/pythons.py build/pythons

fuzz: setup-test ## Give every parser random input (half an hour).
	@$(PIP) install --quiet 'atheris>=3,<4'
	@.venv/bin/python -m stress.fuzz build/bench docs/reliability.md

coverage: setup-test ## Measure branch coverage of estimation and detectors; fail below 90 %.
	@.venv/bin/python -m pytest -q -n logical test/estimation test/detectors test/monitor test/replay/test_offline.py \
		--cov=hijack_detect.estimation --cov=hijack_detect.detectors --cov-branch \
		--cov-report=term:skip-covered --cov-fail-under=90

lock: ## Pin the newest versions that requirements*.in allow (needs uv).
	@for name in requirements requirements-test; do \
		uv pip compile --quiet --upgrade --universal --python-version 3.10 --generate-hashes \
			--custom-compile-command 'make lock' $$name.in --output-file $$name.txt || exit; \
	done

clean: ## Remove .venv and everything that was built.
	rm -rf .venv build install log dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# The ROS wheels exist for these versions of Python on x86-64 Linux only.
define find_python
for name in $(PYTHON) python3 python3.13 python3.12 python3.11 python3.10; do \
	$$name -c 'import sys; sys.exit(not (3, 10) <= sys.version_info[:2] <= (3, 13))' \
		2>/dev/null && python=$$name && break; \
done; \
test -n "$$python" || { echo "No Python 3.10, 3.11, 3.12 or 3.13 found: install one of them," \
	"or name it: make PYTHON=/path/to/python3.12" >&2; exit 1; }; \
test "$$(uname -sm)" = "Linux x86_64" || { echo "ROS 2 wheels exist for x86-64 Linux only:" \
	"here use an installed ROS 2 Jazzy and colcon build" >&2; exit 1; }
endef

# Debian and Ubuntu keep the part of Python that makes a venv in a package of its own.
define need_venv
$$python -c 'import ensurepip, venv' 2>/dev/null || { \
	package=$$($$python -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])'); \
	install="apt-get install -y --no-install-recommends $$package"; \
	test "$$(id -u)" = 0 && command -v apt-get >/dev/null || { \
		echo "$$python cannot make a virtual environment, run: sudo $$install" >&2; exit 1; }; \
	echo "$$install"; \
	apt-get update -qq && DEBIAN_FRONTEND=noninteractive $$install >/dev/null; }
endef

# The report is looked at in a real browser. Where none can be installed, that test says so and skips.
define want_browser
command -v chromium chromium-browser google-chrome >/dev/null || { \
	test "$$(id -u)" = 0 && grep -qs '^ID=debian' /etc/os-release && { \
		echo "apt-get install -y --no-install-recommends chromium (350 MB)"; \
		apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq \
			--no-install-recommends chromium >/dev/null; }; } || true
endef

$(RUNTIME):
	@$(find_python); $(need_venv); \
	echo "Installing ROS 2 Jazzy and the libraries into .venv (650 MB, about a minute)"; \
	rm -rf .venv && $$python -m venv .venv
	@$(FROM_LOCK) -r requirements.txt
	@touch $@

$(TEST): | $(RUNTIME)
	@echo "Installing the tools of the tests into .venv"
	@rm -f .venv/runtime-* .venv/test-*
	@$(want_browser)
	@$(FROM_LOCK) -r requirements.txt -r requirements-test.txt
	@touch $(RUNTIME) $@

# Editable, so that .venv runs the sources as they are; an editable installation has no data
# files, so those are copied and then replaced with links to the checkout.
$(PROJECT): | $(RUNTIME)
	@rm -rf .venv/project-* .venv/lib/hijack_detect .venv/share/hijack_detect
	@$(PIP) install --quiet --no-index --no-deps --no-build-isolation --editable .
	@.venv/bin/python -W ignore setup.py --quiet install_data --install-dir .venv
	@cd .venv/share/hijack_detect && for name in *; do \
		rm -rf "$$name" && ln -s "../../../$$name" "$$name" || exit; done
	@touch $@
