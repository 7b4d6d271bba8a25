# make fly [MISSION=file]   set up everything, then fly a mission in the simulator
# make test                 set up everything, then every test that is quick enough for each change
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
BUILD := build/editable
MISSION ?= examples/first_flight.plan
JOBS ?= 2
TIME ?= 60
CORTEX_M_PACKAGES := gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib qemu-system-arm
BROWSER_PACKAGES := chromium
FUZZ_PACKAGES := clang llvm libclang-rt-14-dev

# $(call needs,commands,packages,for what): installs what is missing where it may, and says what to install otherwise.
define needs
@mkdir -p $(@D)
@missing() { for each in $(1); do command -v $$each >/dev/null || return 0; done; return 1; }; \
if missing && test "$$(id -u)" = 0 && command -v apt-get >/dev/null; then \
  echo "installing for $(3): $(2)"; \
  (apt-get update -qq && apt-get install -qq -y --no-install-recommends $(2)) >/dev/null; \
fi; \
if missing; then echo "$(3) needs $(1): sudo apt-get install $(2)"; exit 1; fi; \
touch $@
endef

.PHONY: fly test test-long reliability sanitized lint analyse audit hashes build boards board-m4 hil fuzz bench clean
fly: build
	$(BIN)/halfroll fly $(MISSION) $(ARGS)

test: lint build board-m4
	$(BIN)/ctest --test-dir $(BUILD) --output-on-failure
	$(BIN)/pytest -n $(JOBS) -m "not long"

test-long: build boards sanitized $(VENV)/clients analyse | build/deps/browser
	$(BIN)/pytest -n $(JOBS) -m long
	PYTHONPATH=tests $(BIN)/python docs/make_reliability.py --check

# docs/reliability.md, from a run of the tests that it speaks of.
reliability: build sanitized
	$(BIN)/pytest -n $(JOBS) -m reliability
	PYTHONPATH=tests $(BIN)/python docs/make_reliability.py

# All C++ under sanitizers, and what has threads under theirs, which tests/test_sanitized_code.py runs.
sanitized: $(VENV)/ready | build/deps/clang build/deps/valgrind
	@for each in asan tsan; do PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/cmake --preset $$each >/dev/null || exit 1; done
	@$(BIN)/cmake --build build/asan -j $(JOBS)
	@$(BIN)/cmake --build build/tsan -j $(JOBS) --target threads_tests

# The firmware on emulated Cortex-M boards: images, flights compared bit by bit, figures in build/hil.json.
hil: build boards
	$(BIN)/python tests/hil/run.py --output build/hil.json
	$(BIN)/pytest tests/hil

boards: board-m4 board-m7

board-m4 board-m7: board-%: $(VENV)/ready | build/deps/cortex-m
	@test -f build/cortex-$*/build.ninja || PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/cmake --preset cortex-$* >build/cortex-$*.log \
	  || (cat build/cortex-$*.log; exit 1)
	@$(BIN)/cmake --build build/cortex-$* -j $(JOBS)

# Each fuzz target for TIME seconds, under sanitizers; figures in build/fuzz.json, what breaks in build/fuzz/run/found.
fuzz: $(VENV)/ready | build/deps/clang
	@test -f build/fuzz/build.ninja || PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/cmake --preset fuzz >/dev/null
	@$(BIN)/cmake --build build/fuzz -j $(JOBS)
	$(BIN)/python tests/fuzz/run.py --seconds $(TIME) --output build/fuzz.json

# What is installed is what is pinned; asks the index and pip-audit, too, where they answer.
audit: $(VENV)/ready
	$(BIN)/python cmake/audit.py --ask

# The digests of every file of every pinned release, by uv (pip install uv); records no host.
hashes:
	uv pip compile constraints.txt --generate-hashes --no-deps --no-header --no-annotate --universal --python-version 3.11 \
	  --quiet --output-file hashes.txt

bench: build
	$(BIN)/python tests/bench/bench.py --output build/bench.json

build: $(VENV)/ready
	@$(BIN)/cmake --build $(BUILD) -j $(JOBS)

build/deps/cortex-m:
	$(call needs,arm-none-eabi-g++ qemu-system-arm,$(CORTEX_M_PACKAGES),the boards)
build/deps/clang:
	$(call needs,clang++ llvm-profdata llvm-cov,$(FUZZ_PACKAGES),fuzzing)
build/deps/browser:
	$(call needs,chromium,$(BROWSER_PACKAGES),tests of the page)
build/deps/valgrind:
	$(call needs,valgrind,valgrind,the check for leaks)
build/deps/analysers:
	$(call needs,clang-tidy cppcheck,clang-tidy cppcheck,static analysis)

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

# Static analysis of the firmware; what is left out, and why, stands in .clang-tidy and .cppcheck.
analyse: build | build/deps/analysers
	cppcheck --quiet --std=c++17 --enable=warning,performance,portability --inline-suppr --error-exitcode=1 \
	  --suppressions-list=.cppcheck -I firmware firmware
	git ls-files 'firmware/*.cpp' ':!firmware/boards/cortex_m' | xargs -P $(JOBS) -n 4 \
	  clang-tidy --quiet -p $(BUILD) --extra-arg=-Wno-unknown-warning-option

clean:
	rm -rf build $(VENV)
