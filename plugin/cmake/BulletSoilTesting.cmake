# add_bullet_soil_regression_test(NAME <name> SCENE <file> BASELINE <file>
#                                 [STEPS <n>] [BACKEND cpu|gl|auto] [THREADS <n>] [TOLERANCE <share>]
#                                 [TIMEOUT <seconds>] [LABELS <labels>...])
#
# Adds a test that runs a scene and compares it with a baseline, by `bsoil check`: soil, conditions and trajectories of
# bodies. Relative files are taken from the current source folder.
#   STEPS      ends the run early; without it, as long as the baseline's, or as the scene says
#   BACKEND    cpu, where it is not given
#   THREADS    of the CPU backend; 0, all cores, where it is not given. The soil is the same with any number
#   TOLERANCE  accepts numbers that are off by this share of the larger of 1 and the value, and does not compare checksums.
#              Without it everything has to be equal, which it is with one build of the same Bullet; the soil alone is
#              equal everywhere
#   TIMEOUT    300 where it is not given
#
# The target <name>.update_baseline writes the baseline, the first one and each after an intended change;
# update_baselines writes all. The test is skipped where the scene's data is not there.
include_guard(GLOBAL)

function(add_bullet_soil_regression_test)
  set(one_value NAME SCENE BASELINE STEPS BACKEND THREADS TOLERANCE TIMEOUT)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "${one_value}" LABELS)
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "add_bullet_soil_regression_test: ${arg_UNPARSED_ARGUMENTS} is not understood")
  endif()
  foreach(needed NAME SCENE BASELINE)
    if(NOT arg_${needed})
      message(FATAL_ERROR "add_bullet_soil_regression_test: ${needed} is missing")
    endif()
  endforeach()
  if(NOT TARGET BulletSoil::bsoil)
    message(FATAL_ERROR "add_bullet_soil_regression_test: there is no bsoil command; ask for the component 'command', and "
                        "install BulletSoil with BULLETSOIL_DEMOS=ON")
  endif()
  cmake_path(ABSOLUTE_PATH arg_SCENE BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
  cmake_path(ABSOLUTE_PATH arg_BASELINE BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
  if(NOT EXISTS ${arg_SCENE})
    message(FATAL_ERROR "add_bullet_soil_regression_test: SCENE ${arg_SCENE} is not there")
  endif()
  if(NOT arg_BACKEND)
    set(arg_BACKEND cpu)
  endif()
  if(NOT arg_BACKEND MATCHES "^(cpu|gl|auto)$")
    message(FATAL_ERROR "add_bullet_soil_regression_test: BACKEND is ${arg_BACKEND}, must be cpu, gl or auto")
  endif()
  if(NOT DEFINED arg_TIMEOUT)
    set(arg_TIMEOUT 300)
  endif()

  set(command BulletSoil::bsoil check ${arg_SCENE} --against ${arg_BASELINE} --backend ${arg_BACKEND})
  foreach(option STEPS THREADS TOLERANCE)
    if(DEFINED arg_${option})
      string(TOLOWER ${option} flag)
      list(APPEND command --${flag} ${arg_${option}})
    endif()
  endforeach()
  add_test(NAME ${arg_NAME} COMMAND ${command})
  set_tests_properties(${arg_NAME} PROPERTIES TIMEOUT ${arg_TIMEOUT} SKIP_RETURN_CODE 77 LABELS "${arg_LABELS}")

  add_custom_target(${arg_NAME}.update_baseline COMMAND ${command} --update VERBATIM
                    COMMENT "Writing ${arg_BASELINE}")
  if(NOT TARGET update_baselines)
    add_custom_target(update_baselines)
  endif()
  add_dependencies(update_baselines ${arg_NAME}.update_baseline)
endfunction()
