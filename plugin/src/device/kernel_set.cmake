# bulletsoil_add_kernel_set(<target> <set> LIST <kernels> BUFFERS <buffers> PARAMS <uniform block> LAYOUT <constants>
#                           COMMON <shared text> [INCLUDED <texts that kernels include>...] [CELLS <cells_of()>])
#
# Compiles the kernels of a list into <target>, as C++ and as embedded GLSL, and with them the function
# `const bsoil::device::KernelSet& bsoil::device::<set>_kernel_set()`. Kernel <name> is <name>.glsl beside the list.
# With CELLS there are kernels that count what they touch, too.
# One set per directory: the compile definitions of cpu_kernels.cpp belong to the directory.
function(bulletsoil_add_kernel_set target set_name)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "LIST;BUFFERS;PARAMS;LAYOUT;COMMON;CELLS" "INCLUDED")
  set(device_dir ${CMAKE_CURRENT_FUNCTION_LIST_DIR})
  set(shader_dir ${PROJECT_SOURCE_DIR}/shaders)
  cmake_path(GET arg_LIST PARENT_PATH kernel_dir)

  # A change of the list changes the set of files, so it configures anew.
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${arg_LIST})
  file(STRINGS ${arg_LIST} entries REGEX "^(PLAIN|SCATTER)\\(")
  set(kernel_files "")
  set(bodies "#include \"${arg_COMMON}\"\n")
  foreach(entry IN LISTS entries)
    string(REGEX REPLACE "^[A-Z]+\\(([a-z0-9_]+)\\).*" "\\1" kernel ${entry})
    list(APPEND kernel_files ${kernel_dir}/${kernel}.glsl)
    string(APPEND bodies "#include \"${kernel_dir}/${kernel}.glsl\"\n")
  endforeach()
  set(bodies_file ${CMAKE_CURRENT_BINARY_DIR}/${set_name}_kernel_bodies.inc)
  file(CONFIGURE OUTPUT ${bodies_file} CONTENT "${bodies}" @ONLY)

  set(shader_files ${arg_COMMON} ${arg_PARAMS} ${arg_LAYOUT} ${arg_INCLUDED} ${kernel_files}
      ${shader_dir}/prelude.glsl ${shader_dir}/exact_math.glsl)
  set(embedded_file ${CMAKE_CURRENT_BINARY_DIR}/${set_name}_shader_files.cpp)
  add_custom_command(
    OUTPUT ${embedded_file}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${embedded_file} -DFUNCTION=${set_name}_shader_files "-DFILES=${shader_files}"
            -P ${device_dir}/embed_shaders.cmake
    DEPENDS ${shader_files} ${device_dir}/embed_shaders.cmake
    COMMENT "Embedding the ${set_name} shaders"
    VERBATIM)

  # No kernel asks for floating point exceptions. Without that word loops with a minimum or a choice in them do not become
  # vectors; their numbers stay the same.
  set(options "$<$<NOT:$<CONFIG:Debug>>:-O3>;-ffp-contract=off;-fno-trapping-math")
  # A fuzzer learns nothing from what kernels compare, and writing it down takes longer than the kernels.
  if(BULLETSOIL_FUZZ)
    list(APPEND options -fno-sanitize-coverage=trace-cmp)
  endif()
  set(definitions
    "BSOIL_KERNEL_SET=${set_name}_kernel_set;BSOIL_SHADER_FILES=${set_name}_shader_files;\
BSOIL_KERNEL_LIST=\"${arg_LIST}\";BSOIL_KERNEL_BUFFERS=\"${arg_BUFFERS}\";BSOIL_KERNEL_PARAMS=\"${arg_PARAMS}\";\
BSOIL_KERNEL_LAYOUT=\"${arg_LAYOUT}\";BSOIL_KERNEL_COMMON=\"${arg_COMMON}\";BSOIL_KERNEL_BODIES=\"${bodies_file}\"")
  set(kernels_file ${device_dir}/cpu_kernels.cpp)
  # The same again for processors with AVX2; the device asks for that when it starts. What is inline in a header must not be
  # taken from there on other processors, so GLM goes by another name (tests/device/check_wide_kernels.sh).
  if(BULLETSOIL_WIDE_KERNELS)
    list(APPEND definitions BSOIL_WIDE_KERNELS=${set_name}_wide_kernels)
    set(wide_file ${CMAKE_CURRENT_BINARY_DIR}/${set_name}_wide_kernels.cpp)
    file(CONFIGURE OUTPUT ${wide_file} CONTENT "#include \"${kernels_file}\"\n" @ONLY)
    set_source_files_properties(${wide_file} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON
      COMPILE_OPTIONS "${options};$<$<NOT:$<CONFIG:Debug>>:-mavx2;-mbmi;-mbmi2;-mpopcnt>"
      COMPILE_DEFINITIONS "${definitions};BSOIL_IS_WIDE;glm=glm_wide")
    target_sources(${target} PRIVATE ${wide_file})
  endif()
  # And once more to count. Nobody times these, so they are optimized for the time of compiling.
  if(arg_CELLS)
    list(APPEND definitions BSOIL_COUNTING_KERNELS=${set_name}_counting_kernels)
    set(counting_file ${CMAKE_CURRENT_BINARY_DIR}/${set_name}_counting_kernels.cpp)
    file(CONFIGURE OUTPUT ${counting_file} CONTENT "#include \"${kernels_file}\"\n" @ONLY)
    set_source_files_properties(${counting_file} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON
      COMPILE_OPTIONS "$<$<NOT:$<CONFIG:Debug>>:-O1>;-ffp-contract=off"
      COMPILE_DEFINITIONS "${definitions};BSOIL_IS_COUNTING;BSOIL_KERNEL_CELLS=\"${arg_CELLS}\"")
    target_sources(${target} PRIVATE ${counting_file})
  endif()
  set_source_files_properties(${kernels_file} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON
    COMPILE_OPTIONS "${options}" COMPILE_DEFINITIONS "${definitions}")
  set_source_files_properties(${embedded_file} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  target_sources(${target} PRIVATE ${kernels_file} ${embedded_file})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/plugin/src ${shader_dir})
endfunction()
