# For a second build of the project, with shared libraries, beside one with static ones (CMAKE_PROJECT_BulletSoil_INCLUDE):
# links them out of that build's archives, which hold the same objects, instead of compiling everything again.
# ARCHIVE_<name>: path of the archive of bulletsoil_<name>.
file(WRITE ${CMAKE_BINARY_DIR}/nothing.cpp "")
function(link_archives)
  foreach(name soil render bullet bullet_double)
    set_property(TARGET bulletsoil_${name} PROPERTY SOURCES ${CMAKE_BINARY_DIR}/nothing.cpp)
    # First of all that is linked: libraries that nothing before them asks for may be left out.
    get_target_property(libraries bulletsoil_${name} LINK_LIBRARIES)
    set_property(TARGET bulletsoil_${name} PROPERTY LINK_LIBRARIES
      $<LINK_LIBRARY:WHOLE_ARCHIVE,${ARCHIVE_${name}}> ${libraries})
  endforeach()
endfunction()
cmake_language(DEFER CALL link_archives)
