/// BSOIL_EXPOSE names private members of Bullet's classes, which gives no way to set what it
/// derives from its own inputs, and derives it with other roundings than it keeps.
#pragma once

namespace bsoil::bullet {
namespace {  // an instantiation has to be where its template is

// An explicit instantiation may name private members; that is all this is.
template <typename Of, auto Member>
struct Expose {
    friend constexpr auto member(Of) { return Member; }
};

}  // namespace
}  // namespace bsoil::bullet

/// In an unnamed namespace of bsoil::bullet. From here on object.*member(name{}) is the member.
#define BSOIL_EXPOSE(name, member_pointer)  \
    struct name {                           \
        friend constexpr auto member(name); \
    };                                      \
    template struct Expose<name, member_pointer>
