#include "bsoil/version.h"

namespace bsoil {

const char* version() { return BSOIL_VERSION; }
int version_number() { return BSOIL_VERSION_NUMBER; }

}  // namespace bsoil
