/// Files that come with the command.
#pragma once

#include <string>

namespace bsoil::command {

/// The folder `name` of the files that are installed with `bsoil`: found from where the program
/// lies, so that an installation may be moved. It need not exist.
std::string shared_folder(const std::string& name);

}  // namespace bsoil::command
