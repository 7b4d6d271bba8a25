# make fly [MISSION=file]   set up everything, then fly a mission in the simulator
# make test                 set up everything, then every test that is quick enough for each change
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
BUILD := build/editable
MISSION ?= examples/first_flight.plan
JOBS ?= 2

.PHONY: fly test test-long lint build bench clean
fly: build
	$(BIN)/halfroll fly $(MISSION) $(ARGS)

test: lint build
	$(BIN)/ctest --test-dir $(BUILD) --output-on-failure
	$(BIN)/pytest -m "not long"

test-long: build $(VENV)/clients
	$(BIN)/pytest -m long

bench: build
	$(BIN)/python tests/bench/bench.py --output build/bench.json

build: $(VENV)/ready
	@$(BIN)/cmake --build $(BUILD) -j $(JOBS)

# The C++ tests need one header that no pip package carries.
build/deps/doctest:
	@mkdir -p build/deps
	@if test -f /usr/include/doctest/doctest.h; then :; \
	elif test "$$(id -u)" = 0 && command -v apt-get >/dev/null; then \
	  echo "fetching Debian package doctest-dev into build/deps (nothing is installed on the system)"; \
	  (apt-get update -qq && cd build/deps && apt-get -o APT::Sandbox::User=root download -qq doctest-dev && dpkg-deb -x doctest-dev_*.deb .) >/dev/null; \
	fi
	@if test -f /usr/include/doctest/doctest.h || test -f build/deps/usr/include/doctest/doctest.h; then touch $@; \
	else echo "The C++ tests need Debian package doctest-dev: sudo apt-get install doctest-dev"; exit 1; fi

# Packages and the editable install, redone only when what they depend on changes; afterwards cmake alone rebuilds C++.
$(VENV)/ready: pyproject.toml constraints.txt | build/deps/doctest
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install -q --disable-pip-version-check -c constraints.txt \
	  $$($(BIN)/python cmake/requirements.py) cmake ninja
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python -m pip install -q --disable-pip-version-check --no-build-isolation --no-deps -e . \
	  -C build-dir=$(BUILD) -C cmake.define.HALFROLL_TESTS=ON
	$(BIN)/python cmake/link_build.py $(BUILD)
	@touch $@

# MAVSDK and MAVProxy, for the tests in tests/system/clients.
$(VENV)/clients: pyproject.toml constraints.txt cmake/requirements.py | $(VENV)/ready
	$(BIN)/python -m pip install -q --disable-pip-version-check --no-deps -c constraints.txt \
	  $$($(BIN)/python cmake/requirements.py clients)
	@touch $@

lint: $(VENV)/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	git ls-files '*.cpp' '*.hpp' | xargs $(BIN)/clang-format --dry-run --Werror

clean:
	rm -rf build $(VENV)
