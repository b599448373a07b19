/// Room in lists that grow and shrink from step to step.
#pragma once

#include <cstddef>
#include <vector>

namespace bsoil {

/// Twice what is asked for, where it is more than there is: a list that grows a little in each step
/// rarely allocates.
template <typename T>
void make_room(std::vector<T>& list, size_t count) {
    if (list.capacity() < count) list.reserve(2 * count);
}

}  // namespace bsoil
