/// How many members a definition has: a table of fields that misses one does not compile.
#pragma once

#include <cstddef>
#include <utility>

namespace bsoil {
namespace members {

/// Converts to whatever a member is of.
struct Anything {
    template <typename T>
    operator T() const;
};
template <typename Def, size_t... I>
constexpr bool has_members(std::index_sequence<I...>) {
    return requires { Def{(static_cast<void>(I), Anything{})...}; };
}

}  // namespace members

/// Members of a definition.
template <typename Def, size_t count = 40>
constexpr size_t member_count() {
    if constexpr (members::has_members<Def>(std::make_index_sequence<count>{})) {
        return count;
    } else {
        return member_count<Def, count - 1>();
    }
}

}  // namespace bsoil
