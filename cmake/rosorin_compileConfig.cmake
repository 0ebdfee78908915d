# find_package(rosorin_compile): the program rosorin-compile, and functions that call it.
#
#   ROSORIN_COMPILE_EXECUTABLE   the program: that of this installation, unless somebody says otherwise
#   rosorin_compile_add_robot()  compiles a robot as a part of the build; docs/builds.md
#
# CMake 3.20 is the first that follows a dependency file with Ninja and with make.

cmake_minimum_required(VERSION 3.20...3.31)

# site-packages/rosorin_compile/cmake stands five folders below the prefix whose bin has the program.
find_program(ROSORIN_COMPILE_EXECUTABLE rosorin-compile
  HINTS "${CMAKE_CURRENT_LIST_DIR}/../../../../../bin"
  DOC "the program rosorin-compile, as pip installs it"
  NO_CMAKE_FIND_ROOT_PATH
)
if(ROSORIN_COMPILE_EXECUTABLE)
  # A list is a program with words, such as python3;-m;rosorin_compile.
  list(GET ROSORIN_COMPILE_EXECUTABLE 0 _rosorin_compile_program)
endif()
if(NOT ROSORIN_COMPILE_EXECUTABLE OR NOT EXISTS "${_rosorin_compile_program}")
  set(rosorin_compile_FOUND FALSE)
  string(CONCAT rosorin_compile_NOT_FOUND_MESSAGE
    "There is no program rosorin-compile (ROSORIN_COMPILE_EXECUTABLE is \"${ROSORIN_COMPILE_EXECUTABLE}\"). Install it:\n"
    "  pip install path/to/rosorin-compile   (a clone of it, or a wheel)\n"
    "or say where it is:\n"
    "  cmake -D ROSORIN_COMPILE_EXECUTABLE=/path/to/bin/rosorin-compile ...\n"
  )
endif()
unset(_rosorin_compile_program)

include("${CMAKE_CURRENT_LIST_DIR}/rosorin_compile_add_robot.cmake")
