# Script: writes OUTPUT, a C++ file that defines FUNCTION, which returns the texts of FILES.
set(entries "")
foreach(file IN LISTS FILES)
  cmake_path(GET file FILENAME name)
  file(READ ${file} text)
  string(APPEND entries "        {\"${name}\", R\"shader(${text})shader\"},\n")
endforeach()
file(WRITE ${OUTPUT} "// Written by embed_shaders.cmake.
#include \"device/kernel_set.h\"

namespace bsoil::device {

std::span<const ShaderFile> ${FUNCTION}();

std::span<const ShaderFile> ${FUNCTION}() {
    static constexpr ShaderFile kFiles[] = {
${entries}    };
    return kFiles;
}

}  // namespace bsoil::device
")
