/// The description of structures that a .bullet file carries ("DNA"), and that Bullet has of its
/// own.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "bsoil/result.h"

namespace bsoil::scene {

/// Structures by number, as blocks of a file name them.
struct BulletDna {
    struct Field {
        std::string type, name;  ///< name without '*' and "[n]"
        size_t offset = 0, size = 0, count = 1;
        int pointer_depth = 0;
        int structure = -1;  ///< number of the type, where it is a structure
    };
    struct Structure {
        std::string name;
        size_t size = 0;
        std::vector<Field> fields;
        const Field* find(std::string_view field) const;
    };

    std::vector<Structure> structures;
    std::map<std::string, int, std::less<>> numbers;   ///< of structures, by name
    std::map<std::string, size_t, std::less<>> sizes;  ///< of all types, by name

    /// A DNA block. Error: it is cut short, or its sizes and numbers do not fit together.
    static Result<BulletDna> parse(std::string_view bytes, size_t pointer_size);
    /// Of the Bullet that this program runs with.
    static const BulletDna& own();

    /// Whether a structure is another one, or begins with it.
    bool is_a(int structure, std::string_view name) const;
    /// Whether Bullet can convert structures of this file to its own without going beyond either.
    bool fits(const BulletDna& own) const;
};

}  // namespace bsoil::scene
