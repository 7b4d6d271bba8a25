# What is made at build time and never committed: MAVLink headers (and the ground's dialect), the tables of shipped vehicles and scenarios,
# the commit that is built.
set(HALFROLL_GENERATED ${CMAKE_BINARY_DIR}/generated)

add_custom_command(
  OUTPUT ${HALFROLL_GENERATED}/mavlink/development/mavlink.h ${HALFROLL_GENERATED}/_dialect.py
  COMMAND ${Python_EXECUTABLE} ${CMAKE_SOURCE_DIR}/cmake/mavlink_dialect.py ${HALFROLL_GENERATED}
  DEPENDS ${CMAKE_SOURCE_DIR}/cmake/mavlink_dialect.py
  COMMENT "Generating the MAVLink dialect" VERBATIM)
add_custom_target(mavlink_dialect DEPENDS ${HALFROLL_GENERATED}/mavlink/development/mavlink.h ${HALFROLL_GENERATED}/_dialect.py)
add_library(mavlink INTERFACE)
add_dependencies(mavlink mavlink_dialect)
target_include_directories(mavlink SYSTEM INTERFACE ${HALFROLL_GENERATED}/mavlink)

foreach(table IN ITEMS vehicle scenario)
  string(TOUPPER ${table} word)
  file(GLOB files CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/ground/halfroll/${table}s/*.toml)
  add_custom_command(
    OUTPUT ${HALFROLL_GENERATED}/${table}s/shipped_${table}s.inc
    COMMAND ${Python_EXECUTABLE} ${CMAKE_SOURCE_DIR}/cmake/number_tables.py ${word} ${HALFROLL_GENERATED}/${table}s/shipped_${table}s.inc ${files}
    DEPENDS ${CMAKE_SOURCE_DIR}/cmake/number_tables.py ${files}
    COMMENT "Generating the table of shipped ${table}s" VERBATIM)
  add_custom_target(${table}_table DEPENDS ${HALFROLL_GENERATED}/${table}s/shipped_${table}s.inc)
endforeach()

# looked up in each build, written when it has changed
add_custom_target(commit
  COMMAND ${CMAKE_COMMAND} -DSOURCE=${CMAKE_SOURCE_DIR} -DHEADER=${HALFROLL_GENERATED}/commit/commit.inc
    -P ${CMAKE_SOURCE_DIR}/cmake/commit.cmake
  BYPRODUCTS ${HALFROLL_GENERATED}/commit/commit.inc
  VERBATIM)
