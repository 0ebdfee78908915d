# find_package(rosorin_compile_cmake): the functions of the installed rosorin-compile, which knows where they are.

find_program(ROSORIN_COMPILE_EXECUTABLE rosorin-compile DOC "the program rosorin-compile, as pip installs it")
if(NOT ROSORIN_COMPILE_EXECUTABLE)
  message(FATAL_ERROR "The program rosorin-compile is not on PATH. Install it:\n"
    "  pip install path/to/rosorin-compile   (a clone of it, or a wheel)\n"
    "or say where it is:\n"
    "  colcon build --cmake-args -D ROSORIN_COMPILE_EXECUTABLE=/path/to/bin/rosorin-compile\n")
endif()

execute_process(COMMAND ${ROSORIN_COMPILE_EXECUTABLE} cmake-dir
  RESULT_VARIABLE _rosorin_compile_failed
  OUTPUT_VARIABLE _rosorin_compile_folder
  ERROR_VARIABLE _rosorin_compile_said
  OUTPUT_STRIP_TRAILING_WHITESPACE
)
if(_rosorin_compile_failed)
  message(FATAL_ERROR "${ROSORIN_COMPILE_EXECUTABLE} cmake-dir fails (${_rosorin_compile_failed}); is it an older one?\n"
    "  pip install --upgrade path/to/rosorin-compile\n${_rosorin_compile_said}")
endif()

find_package(rosorin_compile REQUIRED PATHS "${_rosorin_compile_folder}" NO_DEFAULT_PATH)
unset(_rosorin_compile_failed)
unset(_rosorin_compile_folder)
unset(_rosorin_compile_said)
