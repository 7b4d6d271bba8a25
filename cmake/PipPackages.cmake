# Eigen, pybind11 and the MAVLink generator come as pip packages. Why: one rule for isolated builds, .venv and cross
# builds - ask the interpreter, search nothing else.
execute_process(
  COMMAND ${Python_EXECUTABLE} -c "import importlib.util as u, pathlib
def at(name):
    spec = u.find_spec(name)
    if spec is None or not spec.submodule_search_locations:
        raise SystemExit(f'pip package {name!r} is missing: pip install pybind11 cmeel-eigen pymavlink')
    return pathlib.Path(spec.submodule_search_locations[0]).as_posix()
print(at('cmeel') + '/../cmeel.prefix', at('pybind11') + '/share/cmake/pybind11', sep=';')"
  OUTPUT_VARIABLE _pip OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
list(GET _pip 0 _cmeel)
list(GET _pip 1 _pybind11)
set(pybind11_DIR ${_pybind11} CACHE PATH "pybind11 of the interpreter in use" FORCE)

add_library(Eigen3::Eigen INTERFACE IMPORTED)  # imported, so its headers are system headers
set_target_properties(Eigen3::Eigen PROPERTIES INTERFACE_INCLUDE_DIRECTORIES ${_cmeel}/include/eigen3)
