# demo and test are all a newcomer needs; each sets up what it needs by itself.
PYTHON ?= $(shell scripts/find-python)
VENV := .venv
BIN := $(VENV)/bin

.PHONY: help demo test test-fast coverage test-pythons test-fresh test-boot check check-python check-web web bench fuzz soak soak-page docs clean

help:
	@echo "make demo          run a simulated board, a ROS master, the bridge and the dashboard (no hardware, no ROS)"
	@echo "make test          install what the tests need, and run all tests"
	@echo "make test-fast     run the tests that need no compiler, simulator or ROS"
	@echo "make coverage      check that the unit tests cover every branch of the protocols without I/O"
	@echo "make test-pythons  run the unit, property and contract tests on each installed Python, from 3.11 on"
	@echo "make test-fresh    run what CI runs, in a new Debian 12 made by mmdebstrap (root, 20 minutes)"
	@echo "make test-boot     test the service that starts at boot, on a new Debian 12 (root)"
	@echo "make check         run ruff, mypy, import-linter, reuse, check-words, and the checks of the dashboard's page"
	@echo "make web           build the dashboard's page into src/rostether/dashboard/page"
	@echo "make bench         measure the data path, and compare it with a bare relay"
	@echo "make fuzz          search for inputs that cause errors, ten minutes for each harness (SECONDS=600)"
	@echo "make soak          serve boards on faulty lines (MINUTES=10)"
	@echo "make soak-page     run the dashboard's page under load (MINUTES=30)"
	@echo "make docs          build the documentation into site/"
	@echo "make clean         remove .venv, caches and built files"

demo: $(VENV)/.installed
	@# Ctrl-C ends the demo with 130, which is no error of make. The trap keeps the shell until the demo has ended.
	@trap : INT; $(BIN)/rostether demo $(ARGS) || { status=$$?; [ $$status -eq 130 ] || exit $$status; }

test: $(VENV)/.dev
	scripts/install-peers
	$(BIN)/python -m pytest -n auto --dist worksteal $(ARGS)

# Each process compiles all test modules at its start, unless their byte code is kept.
test test-fast: export PYTHONDONTWRITEBYTECODE :=

test-fast: $(VENV)/.dev
	$(BIN)/python -m pytest tests/architecture tests/unit tests/property tests/contract \
		-m "not (arm or avr or clang or gcc or mingw or qemu or rclpy or ros1 or simavr or slow or systemd)" -n auto --dist worksteal $(ARGS)

coverage: $(VENV)/.dev
	$(BIN)/python -m pytest tests/unit/rosserial tests/unit/serde tests/unit/tcpros tests/unit/xmlrpc \
		-n auto --dist worksteal --cov --cov-report=term-missing:skip-covered $(ARGS)

test-pythons:
	scripts/test-pythons $(ARGS)

test-fresh:
	scripts/test-fresh $(ARGS)

test-boot:
	scripts/test-boot

check: check-web check-python

check-python: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/mypy --scripts-are-modules $$(grep -l "^#!.*python" scripts/*)
	$(BIN)/lint-imports --no-cache
	$(BIN)/reuse lint --quiet
	$(BIN)/python scripts/check-words

# The page's own tools: types, format, tests, and whether the built files are those of its sources.
check-web: web/node_modules/.installed
	cd web && ../$(BIN)/node node_modules/typescript/bin/tsc --noEmit
	cd web && ../$(BIN)/node node_modules/@biomejs/biome/bin/biome check --error-on-warnings .
	mkdir -p web/build
	$(BIN)/python scripts/write-page-vectors web/build/vectors.json
	cd web && ../$(BIN)/node --test "test/*.test.ts"
	$(BIN)/node web/build.mjs --check

web: web/node_modules/.installed
	$(BIN)/node web/build.mjs

web/node_modules/.installed: web/package-lock.json $(VENV)/.dev
	cd web && ../$(BIN)/npm ci --ignore-scripts --no-audit --no-fund --loglevel=error
	touch $@

bench: $(VENV)/.dev
	scripts/install-peers
	$(BIN)/python -m benchmarks $(ARGS)

fuzz: $(VENV)/.dev
	$(BIN)/python -m fuzz all --seconds $(or $(SECONDS),600) $(ARGS)

soak: $(VENV)/.dev
	$(BIN)/python -m benchmarks.soak $(or $(MINUTES),10)

soak-page: web/node_modules/.installed
	$(BIN)/python -m benchmarks.page $(or $(MINUTES),30)

docs: $(VENV)/.dev
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

$(VENV)/.installed: pyproject.toml
	scripts/make-venv "$(PYTHON)" $(VENV)
	@# The demo is in ROS 2 as well where zenoh has a wheel; elsewhere building it would need Rust.
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --retries 1 \
		--only-binary eclipse-zenoh,xxhash --editable ".[zenoh]" 2>/dev/null || \
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --retries 1 --editable . || \
		{ echo "pip could not install what rostether needs; is the network up?" >&2; exit 1; }
	touch $@

$(VENV)/.dev: pyproject.toml .ci/requirements.txt
	scripts/install-dev "$(PYTHON)" $(VENV)
	touch $(VENV)/.installed $@

clean:
	rm -rf $(VENV) .venvs site build dist .mypy_cache .ruff_cache .pytest_cache .hypothesis
