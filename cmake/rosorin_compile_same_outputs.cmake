# Run before a robot is compiled: cmake -P THIS -- ASKED NAME COMMAND...
#
# ASKED is the result of COMMAND, a print --list, from when CMake ran. If it answers something else now, as an included
# file may rename an output, CMake has to run again: it does with the next build, because it depends on ASKED, which
# gets the time of now. What is wrong with the description is left to the compiler, which comes next.

cmake_minimum_required(VERSION 3.20...3.31)

set(command "")
set(after FALSE)
math(EXPR last "${CMAKE_ARGC} - 1")
foreach(index RANGE ${last})
  if(after)
    string(REPLACE ";" "\\;" word "${CMAKE_ARGV${index}}")
    list(APPEND command "${word}")
  elseif(CMAKE_ARGV${index} STREQUAL "--")
    set(after TRUE)
  endif()
endforeach()
list(POP_FRONT command asked name)

execute_process(COMMAND ${command} RESULT_VARIABLE failed OUTPUT_VARIABLE now ERROR_QUIET)
if(failed)
  return()
endif()
string(JSON now GET "${now}" result)
set(before "")
if(EXISTS "${asked}")
  file(READ "${asked}" before)
endif()
if(NOT now STREQUAL before)
  file(TOUCH "${asked}")
  message(FATAL_ERROR "The outputs of the robot ${name} are others than when CMake ran. Build again: CMake runs first.")
endif()
