# bulletsoil_add_kernel_set(<target> <set> LIST <list file> COMMON <shared text>)
#
# Compiles the kernels of a list into <target>, as C++ and as embedded GLSL, and with them the function
# `const bsoil::device::KernelSet& bsoil::device::<set>_kernel_set()`. Kernel <name> is <name>.glsl beside the list.
# One set per directory: the compile definitions of cpu_kernels.cpp belong to the directory.
function(bulletsoil_add_kernel_set target set_name)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "LIST;COMMON" "")
  set(device_dir ${CMAKE_CURRENT_FUNCTION_LIST_DIR})
  set(shader_dir ${PROJECT_SOURCE_DIR}/shaders)
  cmake_path(GET arg_LIST PARENT_PATH kernel_dir)
  cmake_path(GET arg_COMMON FILENAME common_name)

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

  set(shader_files ${arg_COMMON} ${kernel_files})
  foreach(name prelude.glsl exact_math.glsl soil_layout.h soil_params.h)
    list(APPEND shader_files ${shader_dir}/${name})
  endforeach()
  set(embedded_file ${CMAKE_CURRENT_BINARY_DIR}/${set_name}_shader_files.cpp)
  add_custom_command(
    OUTPUT ${embedded_file}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${embedded_file} -DFUNCTION=${set_name}_shader_files "-DFILES=${shader_files}"
            -P ${device_dir}/embed_shaders.cmake
    DEPENDS ${shader_files} ${device_dir}/embed_shaders.cmake
    COMMENT "Embedding the ${set_name} shaders"
    VERBATIM)

  set(kernels_file ${device_dir}/cpu_kernels.cpp)
  set_source_files_properties(${kernels_file} PROPERTIES
    COMPILE_OPTIONS "$<$<NOT:$<CONFIG:Debug>>:-O3>;-ffp-contract=off"
    COMPILE_DEFINITIONS
    "BSOIL_KERNEL_SET=${set_name}_kernel_set;BSOIL_SHADER_FILES=${set_name}_shader_files;\
BSOIL_KERNEL_LIST=\"${arg_LIST}\";BSOIL_KERNEL_COMMON=\"${common_name}\";BSOIL_KERNEL_BODIES=\"${bodies_file}\"")
  target_sources(${target} PRIVATE ${kernels_file} ${embedded_file})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/plugin/src ${shader_dir})
endfunction()
