/// toml++, whose assertions are no promises: bad syntax breaks them ("[[=a]]", "[1,} 2]"), and its
/// code goes on to a proper error where they do nothing. It would abort, or with NDEBUG have clang
/// take them for granted.
#pragma once

#pragma push_macro("NDEBUG")
#undef NDEBUG
#define TOML_ASSERT(expression) static_assert(true)
#define TOML_EXCEPTIONS 0
#define TOML_HEADER_ONLY 0  // the parser itself is compiled once, in schema_table.cpp
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")
