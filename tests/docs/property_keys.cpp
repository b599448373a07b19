/// The worked example of docs/adding_a_property.md, seen from the scenes: prints the keys of
/// [[material]] as a page.
#include <cstdio>

#include "reading/schema_table.h"

int main() {
    std::fputs(bsoil::scene::table_markdown(*bsoil::scene::material_table().spec()).c_str(),
               stdout);
}
