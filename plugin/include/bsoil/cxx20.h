/// Every public header includes this one first: an older C++ is refused in a sentence.
#pragma once

#if __cplusplus < 202002L
#error "BulletSoil needs C++20: compile with -std=c++20 (CMake: set(CMAKE_CXX_STANDARD 20))"
#include <compile_with_c++20>  // is not there: ends the compilation before hundreds of errors
#endif
