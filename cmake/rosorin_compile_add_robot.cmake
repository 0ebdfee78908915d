# rosorin_compile_add_robot(): a robot is compiled as a part of the build, and again when a file changes that it was
# read from. docs/builds.md shows it at work.
#
#   rosorin_compile_add_robot(
#     DESCRIPTION descriptions/arm       # folder, file, or a name in descriptions/
#     [NAME arm]                         # needed where one description is compiled twice
#     [OUTPUTS urdf mjcf]                # names under outputs: of the description; default: all
#     [ARGS prefix:=left_ ...]           # arguments of the description; REMAP is the same
#     [ARGS_FILES calibration.yaml ...]  # files with more of them
#     [PACKAGES name=folder ...]         # where ROS packages are that are not found by themselves
#     [DEPENDS ...]                      # files and targets that have to be there first
#     [TARGET t]                         # the target is ${PROJECT_NAME}_t; default: NAME
#     [GOLDEN [folder]]                  # the build fails where committed artifacts differ; default: as check has it
#     [INSTALL] [DESTINATION share/${PROJECT_NAME}]
#     [QUIET] [TRUST]                    # -q and --trust of rosorin-compile
#   )
#
# Relative paths are seen from CMAKE_CURRENT_SOURCE_DIR. ROSORIN_COMPILE_FILES has the files that are made, absolute.

function(rosorin_compile_add_robot)
  set(flags INSTALL QUIET TRUST)
  set(one DESCRIPTION NAME TARGET DESTINATION)
  set(many OUTPUTS ARGS REMAP ARGS_FILES PACKAGES DEPENDS GOLDEN)
  cmake_parse_arguments(PARSE_ARGV 0 arg "${flags}" "${one}" "${many}")
  set(called "rosorin_compile_add_robot(DESCRIPTION ${arg_DESCRIPTION})")
  _rosorin_compile_check_words()
  _rosorin_compile_find_description()
  _rosorin_compile_names()
  _rosorin_compile_options()
  _rosorin_compile_ask_for_outputs()
  _rosorin_compile_build()
  if(arg_INSTALL OR arg_DESTINATION)
    _rosorin_compile_install()
  endif()
  list(JOIN names ", " names)
  message(STATUS "rosorin-compile: ${arg_NAME}: ${names}")
  set(ROSORIN_COMPILE_FILES "${files}" PARENT_SCOPE)
endfunction()

# End with an error that says which call is wrong.
function(_rosorin_compile_wrong text)
  message(FATAL_ERROR "${called}: ${text}")
endfunction()

# The steps are macros: they read and set the variables of the function above.

# Refuse words that the function does not know, and keywords that lack their value.
macro(_rosorin_compile_check_words)
  set(unknown ${arg_UNPARSED_ARGUMENTS})
  foreach(word IN LISTS arg_ARGS arg_REMAP arg_ARGS_FILES arg_PACKAGES arg_DEPENDS arg_GOLDEN)
    # A misspelt keyword is taken for one more value of the keyword before it.
    if(word MATCHES "^[A-Z][A-Z_]+$" AND NOT TARGET "${word}" AND NOT EXISTS "${CMAKE_CURRENT_SOURCE_DIR}/${word}")
      list(APPEND unknown "${word}")
    endif()
  endforeach()
  if(unknown)
    list(GET unknown 0 word)
    set(help "there are ${flags} ${one} ${many}")
    string(REPLACE ";" " " help "${help}")
    if(word STREQUAL "OUTPUT")
      set(help "OUTPUTS has names under outputs: of the description, which also says how the files are called")
    endif()
    _rosorin_compile_wrong("there is no keyword \"${word}\"; ${help}")
  endif()
  foreach(keyword IN LISTS one)
    if(keyword IN_LIST arg_KEYWORDS_MISSING_VALUES)
      _rosorin_compile_wrong("${keyword} lacks its value")
    endif()
  endforeach()
  list(LENGTH arg_GOLDEN count)
  if(count GREATER 1)
    list(JOIN arg_GOLDEN " " word)
    _rosorin_compile_wrong("GOLDEN is one folder, not ${word}")
  endif()
  if(NOT arg_DESCRIPTION)
    _rosorin_compile_wrong("say DESCRIPTION and a folder, a file, or a name in descriptions/")
  endif()
endmacro()

# Set source, the first file of the description.
macro(_rosorin_compile_find_description)
  set(source "")
  foreach(place IN ITEMS "${arg_DESCRIPTION}" "descriptions/${arg_DESCRIPTION}")
    get_filename_component(place "${place}" ABSOLUTE BASE_DIR "${CMAKE_CURRENT_SOURCE_DIR}")
    if(NOT source AND EXISTS "${place}/robot.yaml")
      set(source "${place}/robot.yaml")
    elseif(NOT source AND EXISTS "${place}" AND NOT IS_DIRECTORY "${place}")
      set(source "${place}")
    endif()
  endforeach()
  if(NOT source)
    _rosorin_compile_wrong(
      "that is no file, no folder with robot.yaml, and no name in descriptions/, seen from ${CMAKE_CURRENT_SOURCE_DIR}")
  endif()
endmacro()

# Set robot, as the program calls the description, target, and folder, where all goes that is made of it.
macro(_rosorin_compile_names)
  get_filename_component(robot "${source}" NAME_WLE)
  if(source MATCHES "/robot\\.yaml$")
    get_filename_component(robot "${source}" DIRECTORY)
    get_filename_component(robot "${robot}" NAME)
  endif()
  if(NOT arg_NAME)
    set(arg_NAME "${robot}")
  endif()
  if(NOT arg_TARGET)
    set(arg_TARGET "${arg_NAME}")
  endif()
  set(target "${PROJECT_NAME}_${arg_TARGET}")
  if(NOT "${arg_NAME}${target}" MATCHES "^[A-Za-z0-9_.+-]+$")
    _rosorin_compile_wrong("\"${arg_NAME}\" cannot name a target; say NAME, of letters, digits, _ . + -")
  endif()
  set(folder "${CMAKE_CURRENT_BINARY_DIR}/rosorin_compile/${arg_NAME}")
  get_property(taken DIRECTORY PROPERTY ROSORIN_COMPILE_ROBOTS)
  if(arg_NAME IN_LIST taken)
    _rosorin_compile_wrong("there is a robot ${arg_NAME} here already; give this one another NAME")
  endif()
  set_property(DIRECTORY APPEND PROPERTY ROSORIN_COMPILE_ROBOTS "${arg_NAME}")
  if(TARGET ${target})
    _rosorin_compile_wrong("there is a target ${target} already; say another NAME or TARGET")
  endif()
endmacro()

# Set words, what all commands take behind the description, and inputs, the files that these name.
macro(_rosorin_compile_options)
  set(words "")
  set(inputs "${source}")
  foreach(word IN LISTS arg_ARGS arg_REMAP)
    if(NOT word MATCHES "^([^:=]+):=(.*)$")
      _rosorin_compile_wrong("ARGS are NAME:=VALUE, not \"${word}\"")
    endif()
    string(REPLACE ";" "\\;" word "${CMAKE_MATCH_1}=${CMAKE_MATCH_2}")
    list(APPEND words -a "${word}")
  endforeach()
  foreach(file IN LISTS arg_ARGS_FILES)
    get_filename_component(file "${file}" ABSOLUTE BASE_DIR "${CMAKE_CURRENT_SOURCE_DIR}")
    if(NOT EXISTS "${file}")
      _rosorin_compile_wrong("there is no file ${file} of arguments")
    endif()
    list(APPEND words --args "${file}")
    list(APPEND inputs "${file}")
  endforeach()
  foreach(word IN LISTS arg_PACKAGES)
    if(NOT word MATCHES "^([^=]+)=(.+)$")
      _rosorin_compile_wrong("PACKAGES are NAME=FOLDER, not \"${word}\"")
    endif()
    get_filename_component(place "${CMAKE_MATCH_2}" ABSOLUTE BASE_DIR "${CMAKE_CURRENT_SOURCE_DIR}")
    list(APPEND words --package "${CMAKE_MATCH_1}=${place}")
  endforeach()
  if(arg_TRUST)
    list(APPEND words --trust)
  endif()
endmacro()

# Set names, the outputs that are asked for, and files, what is made for them: the program knows how they are called.
macro(_rosorin_compile_ask_for_outputs)
  # In quotes, or a\;b becomes a;b.
  set(ask "${ROSORIN_COMPILE_EXECUTABLE};print;--list;--format;json;${source};${words}")
  set(asked "${folder}/outputs.json")
  execute_process(COMMAND ${ask} WORKING_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}"
    RESULT_VARIABLE failed OUTPUT_VARIABLE answer ERROR_VARIABLE said)
  if(failed)
    set(messages "${ROSORIN_COMPILE_EXECUTABLE};print;--list;${source};${words}")  # in the form for people
    execute_process(COMMAND ${messages} WORKING_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" OUTPUT_QUIET ERROR_VARIABLE said)
    string(REPLACE "\n" "\n  " said "\n${said}")  # what is indented, CMake prints as it is
    _rosorin_compile_wrong("${said}")
  endif()
  string(JSON answer GET "${answer}" result)
  set(before "")
  if(EXISTS "${asked}")
    file(READ "${asked}" before)
  endif()
  file(WRITE "${asked}" "${answer}")
  # A change of these makes CMake run again; others are noticed when the robot is compiled.
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${inputs} "${asked}")
  _rosorin_compile_read_outputs()
  _rosorin_compile_forget_others()
endmacro()

# Take names and files out of the answer; files are those of outputs that are asked for.
macro(_rosorin_compile_read_outputs)
  set(names "")
  set(files "")
  set(known "")
  string(JSON count LENGTH "${answer}")
  if(count GREATER 0)
    math(EXPR count "${count} - 1")
    foreach(index RANGE ${count})
      string(JSON name GET "${answer}" ${index} name)
      string(JSON file GET "${answer}" ${index} file)
      list(APPEND known "${name}")
      if(NOT arg_OUTPUTS OR name IN_LIST arg_OUTPUTS)
        list(APPEND names "${file}")
        list(APPEND files "${folder}/${robot}/${file}")
      endif()
    endforeach()
  endif()
  foreach(name IN LISTS arg_OUTPUTS)
    if(NOT name IN_LIST known)
      list(JOIN known ", " known)
      _rosorin_compile_wrong("the robot has no output \"${name}\"; under outputs: of the description are ${known}")
    endif()
  endforeach()
  if(NOT files)
    _rosorin_compile_wrong("the robot has nothing to make; say under outputs: of the description what you want")
  endif()
endmacro()

# Remove what former runs made under names that are no outputs any more: it would be installed with the rest.
macro(_rosorin_compile_forget_others)
  string(JSON count ERROR_VARIABLE broken LENGTH "${before}")
  if(count GREATER 0)
    math(EXPR count "${count} - 1")
    foreach(index RANGE ${count})
      string(JSON file GET "${before}" ${index} file)
      if(NOT file IN_LIST names)
        file(REMOVE "${folder}/${robot}/${file}")
      endif()
    endforeach()
  endif()
endmacro()

# The commands, and the target that has their results.
macro(_rosorin_compile_build)
  set(only "")
  foreach(name IN LISTS arg_OUTPUTS)
    list(APPEND only --only "${name}")
  endforeach()
  if(arg_QUIET)
    list(APPEND words --quiet)
  endif()
  list(GET ROSORIN_COMPILE_EXECUTABLE 0 program)
  # colcon points out a package whose build prints to standard error: how far a robot is does not go there.
  set(silently "${CMAKE_COMMAND}" -E env ROSORIN_COMPILE_PROGRESS=off)
  list(GET files 0 first)
  list(JOIN names ", " listed)
  set(forget "")
  if(CMAKE_GENERATOR MATCHES "Makefiles")
    # CMake adds to what it knows of dependencies, and never takes a file out that is not read any more: if that is gone,
    # make runs the command each time. Without its notes it reads the dependency files anew. The target is ours alone.
    set(forget COMMAND "${CMAKE_COMMAND}" -E rm -f
      "${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${target}.dir/compiler_depend.internal")
  endif()
  add_custom_command(
    OUTPUT ${files}
    COMMAND "${CMAKE_COMMAND}" -P "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/rosorin_compile_same_outputs.cmake"
      -- "${asked}" "${arg_NAME}" ${ask}
    COMMAND ${silently} ${ROSORIN_COMPILE_EXECUTABLE} all "${source}" ${only} -o "${folder}/${robot}"
      --depfile "${folder}/outputs.d" --depfile-target "${first}" ${words}
    ${forget}
    DEPENDS ${inputs} "${program}" ${arg_DEPENDS}
    DEPFILE "${folder}/outputs.d"
    WORKING_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}"
    COMMENT "rosorin-compile: ${arg_NAME}: ${listed}"
    VERBATIM
  )
  set(results ${files})
  if("GOLDEN" IN_LIST arg_KEYWORDS_MISSING_VALUES OR arg_GOLDEN)
    _rosorin_compile_golden()
  endif()
  add_custom_target(${target} ALL DEPENDS ${results})
  set_property(DIRECTORY APPEND PROPERTY ADDITIONAL_CLEAN_FILES "${folder}/${robot}")
endmacro()

# The command that holds the committed artifacts against the description.
macro(_rosorin_compile_golden)
  set(committed "${arg_GOLDEN}")
  if(NOT committed)  # where the program writes when nobody says where
    set(committed outputs)
    if(source MATCHES "^(.*)/descriptions/[^/]+/[^/]+$")
      set(committed "${CMAKE_MATCH_1}/outputs")
    endif()
  endif()
  get_filename_component(committed "${committed}" ABSOLUTE BASE_DIR "${CMAKE_CURRENT_SOURCE_DIR}")
  set(stamp "${folder}/golden.stamp")
  add_custom_command(
    OUTPUT "${stamp}"
    COMMAND ${silently} ${ROSORIN_COMPILE_EXECUTABLE} check "${source}" -o "${committed}/${robot}"
      --depfile "${folder}/golden.d" --depfile-target "${stamp}" ${words}
    COMMAND "${CMAKE_COMMAND}" -E touch "${stamp}"
    ${forget}
    DEPENDS ${inputs} "${program}" ${arg_DEPENDS}
    DEPFILE "${folder}/golden.d"
    WORKING_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}"
    COMMENT "rosorin-compile: ${arg_NAME}: the committed artifacts"
    VERBATIM
  )
  list(APPEND results "${stamp}")
endmacro()

# Install the artifacts, and the meshes beside them: how those are called is known when the robot is compiled.
macro(_rosorin_compile_install)
  if(NOT arg_DESTINATION)
    set(arg_DESTINATION "share/${PROJECT_NAME}")
  endif()
  foreach(name IN LISTS names)
    get_property(taken GLOBAL PROPERTY ROSORIN_COMPILE_INSTALLED)
    if("${arg_DESTINATION}/${name}" IN_LIST taken)
      _rosorin_compile_wrong(
        "${arg_DESTINATION}/${name} is installed by another robot already; say another DESTINATION")
    endif()
    set_property(GLOBAL APPEND PROPERTY ROSORIN_COMPILE_INSTALLED "${arg_DESTINATION}/${name}")
  endforeach()
  if(COMMAND ament_package AND NOT arg_DESTINATION MATCHES "^(/|(share|lib|include|bin|etc)(/|$))")
    message(WARNING "${called}: DESTINATION is seen from the prefix, as install() has it; xacro_add_files puts "
      "share/${PROJECT_NAME}/ before it. Write share/${PROJECT_NAME}/${arg_DESTINATION}")
  endif()
  install(DIRECTORY "${folder}/${robot}/" DESTINATION "${arg_DESTINATION}")
endmacro()
