# bulletsoil_install_library(<target> <name>)
#
# Makes <target> what a host links as BulletSoil::<name>, in the build tree and installed, and installs it with its
# own export file, so that find_package loads the components it is asked for and no others.
# Components of the installation: `runtime` (shared libraries, the command, its data), `development` (the rest).
include(GNUInstallDirs)
set(BULLETSOIL_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/BulletSoil)
set(BULLETSOIL_PKGCONFIG_DIR ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
set(BULLETSOIL_SHARE_DIR ${CMAKE_INSTALL_DATADIR}/bulletsoil)

# Before 1.0 a minor version may break the ABI.
if(PROJECT_VERSION_MAJOR EQUAL 0)
  set(BULLETSOIL_SOVERSION 0.${PROJECT_VERSION_MINOR})
else()
  set(BULLETSOIL_SOVERSION ${PROJECT_VERSION_MAJOR})
endif()

# Public headers switch to default visibility. The project's own tests look behind them.
if(NOT (BUILD_SHARED_LIBS AND BULLETSOIL_TESTS))
  set(CMAKE_CXX_VISIBILITY_PRESET hidden)
  set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
endif()

function(bulletsoil_install_library target name)
  add_library(BulletSoil::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES
    EXPORT_NAME ${name}
    VERSION ${PROJECT_VERSION}
    SOVERSION ${BULLETSOIL_SOVERSION}
    DEFINE_SYMBOL ""  # shared and static libraries are made of the same objects
    INSTALL_RPATH "$ORIGIN")
  target_compile_features(${target} PUBLIC cxx_std_20)
  install(TARGETS ${target} EXPORT BulletSoil_${name}
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT development
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
    INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT BulletSoil_${name} NAMESPACE BulletSoil:: DESTINATION ${BULLETSOIL_CMAKE_DIR} COMPONENT development)
endfunction()

# bulletsoil_check_built_before_install(<component> TARGETS <names>... [SHARED_TARGETS <names>...])
#
# To be called before anything is installed: where one of the targets (that exist; `soil` stands for bulletsoil_soil) has not
# been built, as after demos/run.sh, the installation ends with a sentence instead of half-way.
function(bulletsoil_check_built_before_install component)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "TARGETS;SHARED_TARGETS")
  if(BUILD_SHARED_LIBS)
    list(APPEND arg_TARGETS ${arg_SHARED_TARGETS})
  endif()
  set(files "")
  foreach(name IN LISTS arg_TARGETS)
    foreach(target ${name} bulletsoil_${name})
      string(APPEND files " \"$<$<TARGET_EXISTS:${target}>:$<TARGET_FILE:${target}>>\"")
    endforeach()
  endforeach()
  install(CODE "
foreach(file IN ITEMS${files})
  if(file AND NOT EXISTS \"\${file}\")
    message(FATAL_ERROR \"\${file} is not built, so nothing was installed; build everything first: cmake --build ${PROJECT_BINARY_DIR}\")
  endif()
endforeach()" COMPONENT ${component})
endfunction()

# bulletsoil_install_headers(<folder>): what lies in it goes to include/.
function(bulletsoil_install_headers folder)
  install(DIRECTORY ${folder}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development FILES_MATCHING PATTERN "*.h")
endfunction()

# bulletsoil_install_pkg_config(<package> DESCRIPTION <text> LIBRARY <target> [REQUIRES <packages>...]
#                               [STATIC_REQUIRES <packages>...] [STATIC_LIBS <flags>...] [CFLAGS <flags>...])
#
# STATIC_...: what a host of the static library has to link; a shared one brings it along. The file finds its prefix from
# where it lies itself.
function(bulletsoil_install_pkg_config package)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "DESCRIPTION;LIBRARY" "REQUIRES;STATIC_REQUIRES;STATIC_LIBS;CFLAGS")
  if(NOT BUILD_SHARED_LIBS)
    list(APPEND arg_REQUIRES ${arg_STATIC_REQUIRES})
  else()
    set(arg_STATIC_LIBS "")
  endif()
  list(JOIN arg_REQUIRES ", " requires)
  list(JOIN arg_STATIC_LIBS " " static_libs)
  list(JOIN arg_CFLAGS " " cflags)
  get_target_property(library ${arg_LIBRARY} NAME)
  # A distribution may give folders that do not lie in the prefix.
  if(IS_ABSOLUTE "${BULLETSOIL_PKGCONFIG_DIR}")
    set(prefix "${CMAKE_INSTALL_PREFIX}")
  else()
    file(RELATIVE_PATH prefix /${BULLETSOIL_PKGCONFIG_DIR} /)
    string(REGEX REPLACE "/$" "" prefix "\${pcfiledir}/${prefix}")
  endif()
  foreach(kind LIBDIR INCLUDEDIR)
    string(TOLOWER ${kind} dir)
    set(${dir} "${CMAKE_INSTALL_${kind}}")
    if(NOT IS_ABSOLUTE "${${dir}}")
      string(PREPEND ${dir} "\${prefix}/")
    endif()
  endforeach()
  set(file ${CMAKE_CURRENT_BINARY_DIR}/${package}.pc)
  file(CONFIGURE OUTPUT ${file} @ONLY CONTENT [[
prefix=@prefix@
libdir=@libdir@
includedir=@includedir@

Name: @package@
Description: @arg_DESCRIPTION@
Version: @PROJECT_VERSION@
Requires: @requires@
Libs: -L${libdir} -l@library@ @static_libs@
Cflags: -I${includedir} @cflags@
]])
  install(FILES ${file} DESTINATION ${BULLETSOIL_PKGCONFIG_DIR} COMPONENT development)
endfunction()
