# Run by the test `install` of CMakeLists.txt.
set(prefix ${WORK_DIR}/prefix)
set(build ${WORK_DIR}/consumer-build)
file(REMOVE_RECURSE ${prefix} ${build})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix}
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
# The library alone, without what it is measured against, and without what that needs.
file(GLOB_RECURSE installed RELATIVE ${prefix} ${prefix}/*)
list(FILTER installed INCLUDE REGEX "rivals|survey|odeint|celledoni")
if(installed)
  message(FATAL_ERROR "installed, and not of the library: ${installed}")
endif()
file(GLOB_RECURSE packages ${prefix}/*.cmake)
foreach(package ${packages})
  file(READ ${package} text)
  if(text MATCHES "[Ss]undials|SUNDIALS|[Bb]oost")
    message(FATAL_ERROR "${package} asks users for ${CMAKE_MATCH_0}")
  endif()
endforeach()

execute_process(COMMAND ${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${build} -G ${GENERATOR}
  -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_BUILD_TYPE=${BUILD_TYPE} -D CMAKE_CXX_COMPILER=${CXX_COMPILER}
  -D "CMAKE_CXX_FLAGS_DEBUG=${CXX_FLAGS_DEBUG}"
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${build} COMMAND_ERROR_IS_FATAL ANY)

# Toutatis' long axis, ecliptic J2000, from Euler's equations and the attitude's by Runge-Kutta steps of 43.2 s, 20 digits.
set(expected "+0.917466 +0.381078 +0.114172\n")
execute_process(COMMAND ${build}/consumer ${SOURCE_DIR}/data/bodies/toutatis.toml
  OUTPUT_VARIABLE found COMMAND_ERROR_IS_FATAL ANY)
if(NOT found STREQUAL expected)
  message(FATAL_ERROR "the consumer found ${found}instead of ${expected}")
endif()

execute_process(COMMAND ${build}/batch ${SOURCE_DIR}/data/bodies/toutatis.toml
  OUTPUT_VARIABLE found COMMAND_ERROR_IS_FATAL ANY)
if(NOT found STREQUAL "527040 instants, components of q within 1e-14: yes\n")
  message(FATAL_ERROR "the consumer found ${found}")
endif()

execute_process(COMMAND ${build}/partials ${SOURCE_DIR}/data/bodies/toutatis.toml
  OUTPUT_VARIABLE found COMMAND_ERROR_IS_FATAL ANY)
if(NOT found STREQUAL "0.00342 rad\n")
  message(FATAL_ERROR "the consumer found ${found}")
endif()

# Envisat's third axis, from Euler's equations in named axes by scipy's DOP853 to 1e-12.
execute_process(COMMAND ${build}/own_torque ${SOURCE_DIR}/data/bodies/envisat.toml
  OUTPUT_VARIABLE found COMMAND_ERROR_IS_FATAL ANY)
if(NOT found STREQUAL "+0.782501 +0.415181 -0.464023, good to 1e-8 rad\n")
  message(FATAL_ERROR "the consumer found ${found}")
endif()

# README and manual show these very programs.
foreach(shown "main.cpp;README.md" "batch.cpp;tools/manual/numerical-analysis.md"
    "partials.cpp;tools/manual/partials.md" "own_torque.cpp;tools/manual/library.md")
  list(GET shown 0 program)
  list(GET shown 1 page)
  file(READ ${SOURCE_DIR}/${page} text)
  file(READ ${CONSUMER_DIR}/${program} example)
  string(FIND "${text}" "```cpp\n${example}```" place)
  if(place EQUAL -1)
    message(FATAL_ERROR "the example in ${page} is not tests/install/consumer/${program}")
  endif()
endforeach()

if(WITH_PROGRAM)
  execute_process(COMMAND ${prefix}/bin/polhode --help OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endif()
