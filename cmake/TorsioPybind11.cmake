# Finds Python and pybind11 for the extension modules.
find_package(Python 3.10 REQUIRED COMPONENTS Interpreter Development.Module)
find_package(pybind11 2.12 CONFIG QUIET)
if(NOT pybind11_FOUND)
  # A pip-installed pybind11 knows where its CMake files are; its program quotes them for a shell.
  execute_process(COMMAND "${Python_EXECUTABLE}" -c
    "import pybind11; print(pybind11.get_cmake_dir())"
    OUTPUT_VARIABLE pybind11_DIR OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  find_package(pybind11 2.12 CONFIG REQUIRED)
endif()
