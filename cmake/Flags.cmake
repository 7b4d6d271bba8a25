# Flags every target shares. Why: floating-point contraction and Eigen's layout must agree everywhere, or host, module
# and board stop giving the same bits.
add_library(halfroll_flags INTERFACE)
target_compile_options(halfroll_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Werror -ffp-contract=off -fno-math-errno)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(halfroll_flags INTERFACE -Wno-maybe-uninitialized)  # GCC sees ghosts in empty std::optionals
endif()
if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  target_compile_options(halfroll_flags INTERFACE -Wno-unused-lambda-capture)  # of empty parameter packs
endif()
if(CMAKE_CROSSCOMPILING)
  target_compile_options(halfroll_flags INTERFACE -fcallgraph-info=su)  # who calls whom, and the stack each takes: tests/hil/stack_depth.py
endif()
target_compile_definitions(halfroll_flags INTERFACE EIGEN_DONT_VECTORIZE EIGEN_NO_MALLOC)
if(HALFROLL_SANITIZE OR CMAKE_BUILD_TYPE STREQUAL "Debug")
  target_compile_definitions(halfroll_flags INTERFACE HALFROLL_CHECKED)  # sim/sitl/checked.hpp
endif()
add_library(sanitized_flags INTERFACE)
if(HALFROLL_SANITIZE)
  target_compile_options(sanitized_flags INTERFACE -fsanitize=${HALFROLL_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer
    -fno-sanitize=vptr  # the firmware has no RTTI
    -fsanitize-ignorelist=${CMAKE_SOURCE_DIR}/cmake/modular.txt)
  target_link_options(sanitized_flags INTERFACE -fsanitize=${HALFROLL_SANITIZE})
endif()
target_link_libraries(halfroll_flags INTERFACE sanitized_flags)

# What fuzzing follows: the firmware, not the world around it, Eigen or the search for broken invariants, which would be
# most of what it sees. Lines are counted where messages are understood (tests/fuzz/run.py).
add_library(fuzzed_flags INTERFACE)
if(HALFROLL_FUZZ)
  target_compile_options(fuzzed_flags INTERFACE -fsanitize=fuzzer-no-link
    -fsanitize-coverage-ignorelist=${CMAKE_SOURCE_DIR}/tests/fuzz/not_followed.txt
    -fprofile-instr-generate -fcoverage-mapping -fprofile-list=${CMAKE_SOURCE_DIR}/tests/fuzz/counted.txt)
  target_link_options(halfroll_flags INTERFACE -fprofile-instr-generate)
endif()
