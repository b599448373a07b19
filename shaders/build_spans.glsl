// Whether no body covers the voxel, but for a small one: soil all around it stands as high as without it.
bool is_uncovered(int voxel) {
    if (state_at(kPlaneCoverage, voxel) == 0) return true;
    int body = owner_body(state_at(kPlaneOwner, voxel));
    return body >= 0 && shapes[body * kBodyWords + kBodyPlace] != 0;
}

// Whether none covers the voxel of a span's top or the one on it.
bool is_top_free(int column, int top) {
    int zt = min(params.height - 1, top >> 16);
    int at_top = column + zt * kTileColumns;
    return is_uncovered(at_top) && (zt + 1 >= params.height || is_uncovered(at_top + kTileColumns));
}

// Notes what span `index` of a column stands on: index + 1 of a body, 0 for the ground.
void note_base(int record, int index, int base) {
    int at = record + kColumnBase + (index >> 1);
    spans[at] = (index & 1) == 0 ? base : spans[at] | (base << 16);
}

int column_terrain(int column, int z) { return state_at(kPlaneTerrain, column + z * kTileColumns); }
int column_volume(int column, int z) { return state_at(kPlaneVolume, column + z * kTileColumns); }

#include "column_surface.glsl"

// The multi-level heightfield, thesis Tables 1 to 3 and (30): the sorted height spans of every column. The vertical index
// grows upwards here (in the thesis it grows downwards). Heights are Q16 voxels above the floor. Edge spans depend on
// the neighbours and are made where they are used, in slip_soil. One group per tile, a lane a column.
// Columns that have not changed since the pass before have the same spans.
// Reads: coverage, owner, terrain, volume, support, shapes, stamps. Writes: spans.
int build_spans_lanes(int group, int half_at) {
    return changed_half(entry_slot(block_list[params.list_offset + group]), half_at, params.spans_stamp);
}

void build_spans(int group, int lane) {
    int entry = block_list[params.list_offset + group];
    int slot = entry_slot(entry);
    int full = spans[column_word(kColumnFull, slot * kTileColumns + lane)];
    // One voxel of air tells what lies below apart from what may come above.
    int end = min(entry_highest(entry) * 8, spans[column_word(kColumnEnd, slot * kTileColumns + lane)] + 1);
    int column = slot * params.tile_voxels + lane;
    int record = (slot * kTileColumns + lane) * kColumnWords;
    int count = 0;
    int kind = kSpanPiled;   // a piled span starts on the floor, even an empty one: soil can slide onto it
    int bottom = 0;
    int top = full * kVoxelFull;  // of the open span
    bool on_body = false;    // the span stands on a body, so that its top is not the ground's surface
    int carrier = 0;         // index + 1 of that body if it may move
    int surface = 0;         // of the topmost piled span of the ground
    bool surface_free = true;
    int bare = kNotBare;     // see bare_surface()
    bool climbs = false;
    bool lost = false;
    int lost_at = 0;         // where the last span that does not fit starts
    for (int z = full; z <= end; ++z) {
        int voxel = column + z * kTileColumns;
        bool inside = z < end;
        int bodies = inside ? state_at(kPlaneCoverage, voxel) : 0;
        int terrain = inside ? state_at(kPlaneTerrain, voxel) : 0;
        int volume = inside ? state_at(kPlaneVolume, voxel) : 0;
        int coverage = min(kVoxelFull, bodies + terrain);
        int base = z * kVoxelFull;
        int next = 0;        // kind of span that starts with this voxel; 0 = none
        bool ends = false;
        bare = climbs && terrain > 0 ? base + min(kVoxelFull, terrain) : bare;
        climbs = climbs && terrain >= kSolidCoverage;
        if (!inside) {
            ends = true;
        } else if (coverage >= kSolidCoverage) {
            // Table 1
            if (kind != kSpanRigid) {
                ends = true;
                next = kSpanRigid;
            } else {
                top = base + kVoxelFull;
            }
        } else if (kind == kSpanRigid) {
            ends = true;     // Table 2: a piled span starts directly on a rigid one
            next = kSpanPiled;
        } else if (kind == kSpanPiled) {
            if (top == base && volume + coverage > 0) {
                // Table 2: coverage counts as height where it carries the soil, not where a body hangs into it.
                bool stands = bottom == base;
                int reach = volume + (stands ? coverage : 0);
                int slack = kSupportSlack;
                if (volume > 0 && state_at(kPlaneSupport, voxel) >= kSupportBody) {
                    slack = kCarrySlack;
                }
                bool passes = volume + coverage >= kVoxelFull - slack;
                top = passes ? base + kVoxelFull : base + min(kVoxelFull, reach);
            } else if (volume >= kVoxelFull && coverage == 0) {
                ends = true;
                next = kSpanFalling;  // Table 3
            }
        } else if (kind == kSpanFalling) {
            if (volume < kVoxelFull || coverage > 0) {
                ends = true;
            } else {
                top = base + kVoxelFull;
            }
        } else if (volume >= kVoxelFull && coverage == 0) {
            next = kSpanFalling;  // Table 3
        }
        if (ends && kind != 0) {
            if (count < kSpanCapacity) {
                int at = record + kColumnSpans + count * kSpanWords;
                spans[at + kSpanBottom] = bottom;
                spans[at + kSpanTop] = top;
                spans[at + kSpanKind] = kind;
                bool carried = kind == kSpanPiled && carrier > 0;
                note_base(record, count, !carried ? 0 : is_top_free(column, top) ? carrier | kBaseFree : carrier);
                count += 1;
            } else {
                lost = true;
                lost_at = min(bottom >> 16, params.height - 1);
            }
            if (kind == kSpanPiled && !on_body && is_surface(bottom, top)) {
                surface = top;
                climbs = terrain >= kSolidCoverage && is_on_top(z, top);
                bare = climbs ? base + min(kVoxelFull, terrain) : kNotBare;
                surface_free = is_top_free(column, top);
            }
            kind = 0;
        }
        if (coverage >= kSolidCoverage) {
            on_body = bodies > terrain;  // after the span below was closed: it stands on what is further down
            int body = on_body ? owner_body(state_at(kPlaneOwner, voxel)) : -1;
            carrier = body >= 0 && shapes[body * kBodyWords + kBodyMoving] != 0 ? body + 1 : 0;
        }
        if (next != 0) {
            kind = next;
            bottom = base;
            top = base;
            if (kind == kSpanPiled) {
                int slack = kSupportSlack;
                if (volume > 0 && state_at(kPlaneSupport, voxel) >= kSupportBody) {
                    slack = kCarrySlack;
                }
                top = volume + coverage >= kVoxelFull - slack
                          ? base + kVoxelFull
                          : base + min(kVoxelFull, volume > 0 ? volume + coverage : 0);
            } else {
                top = base + kVoxelFull;
            }
        }
    }
    int intact = column_word(kColumnIntact, slot * kTileColumns + lane);
    if (spans[intact] == kIntactUnknown && params.bank_strength > 0) {
        int z = 0;
        while (z < params.height && is_intact(column + z * kTileColumns)) z += 1;
        spans[intact] = z;
    }
    int known = spans[record + kColumnCount];  // beyond these all speeds are 0
    spans[record + kColumnCount] = count;
    for (int i = count; i < known; ++i) {
        spans[record + kColumnSpeed + i] = 0;
        spans[record + kColumnSpeed + kSpanCapacity + i] = 0;
    }
    int word = surface;
    if (bare != kNotBare) {
        word = kTerrainTop - bare;
    } else if (!surface_free) {
        word = bare_surface(column, full, end);
        word = word < 0 ? word : kCovered - word;
    }
    bool is_single = count == 1 && spans[record + kColumnSpans + kSpanKind] == kSpanPiled &&
                     spans[record + kColumnSpans + kSpanBottom] == 0;
    spans[column_word(kColumnSingle, slot * kTileColumns + lane)] =
        is_single ? spans[record + kColumnSpans + kSpanTop] : kNotSingle;
    spans[column_word(kColumnSurface, slot * kTileColumns + lane)] = word;
    if (lost) {
        note_condition(kStatusSpansFull, kResultSpansPlace,
                       grid_voxel(slot, lane & 7, lane >> 3, lost_at));
    }
}
