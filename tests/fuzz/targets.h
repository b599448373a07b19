/// The fuzz targets, each in a file of its own name or of what it reads.
#pragma once

#include "fuzz_target.h"

namespace bsoil::fuzz {

// --- files as a user writes them: the bytes are the file
void fuzz_scene(Bytes bytes);       ///< and two steps of it where it is small
void fuzz_experiment(Bytes bytes);  ///< read only
void fuzz_urdf(Bytes bytes);        ///< the first byte says what a scene makes of it
void fuzz_mesh_file(Bytes bytes);   ///< the first byte: OBJ, STL or DAE, and what becomes of it
void fuzz_height_map(Bytes bytes);  ///< a PNG
void fuzz_table(Bytes bytes);       ///< CSV
void fuzz_baseline(Bytes bytes);    ///< JSON

// --- files that programs write: the bytes are changes to a good one, checksums put right
void fuzz_bullet_file(Bytes bytes);
void fuzz_snapshot_file(Bytes bytes);
void fuzz_soil_state(Bytes bytes);
void fuzz_world_snapshot(Bytes bytes);

// --- calls: the bytes choose them and their arguments; soil is conserved, whatever they are
void fuzz_surface_mesher(Bytes bytes);
void fuzz_soil_calls(Bytes bytes);    ///< bsoil/soil.h
void fuzz_action_calls(Bytes bytes);  ///< bsoil/bullet/
void fuzz_c_calls(Bytes bytes);       ///< bsoil/c/bulletsoil.h

}  // namespace bsoil::fuzz
