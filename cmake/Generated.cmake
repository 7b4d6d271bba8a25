# What is made at build time and never committed: MAVLink headers (and the ground's dialect), the table of shipped vehicles.
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

file(GLOB HALFROLL_VEHICLES CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/ground/halfroll/vehicles/*.toml)
add_custom_command(
  OUTPUT ${HALFROLL_GENERATED}/vehicles/shipped_vehicles.inc
  COMMAND ${Python_EXECUTABLE} ${CMAKE_SOURCE_DIR}/cmake/vehicle_table.py ${HALFROLL_GENERATED}/vehicles/shipped_vehicles.inc ${HALFROLL_VEHICLES}
  DEPENDS ${CMAKE_SOURCE_DIR}/cmake/vehicle_table.py ${HALFROLL_VEHICLES}
  COMMENT "Generating the table of shipped vehicles" VERBATIM)
add_custom_target(vehicle_table DEPENDS ${HALFROLL_GENERATED}/vehicles/shipped_vehicles.inc)
