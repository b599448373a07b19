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

int column_terrain(int column, int z) { return state_at(kPlaneTerrain, column + z * kTileColumns); }
int column_volume(int column, int z) { return state_at(kPlaneVolume, column + z * kTileColumns); }

// As find_support has found it: what stands on a body is no roof where there are none.
bool is_column_roof(int column, int z) {
    if (params.bank_strength <= 0 || z == 0) return false;
    int slot = column / params.tile_voxels;
    int hollow = spans[column_word(kColumnHollow, slot * kTileColumns + column - slot * params.tile_voxels)];
    int voxel = column + z * kTileColumns;
    if (hollow == 0 || z + 1 < hollow || state_at(kPlaneSupport, voxel) != kSupportGround || !is_bonded(voxel)) return false;
    int below = voxel - kTileColumns;
    int filled = state_at(kPlaneVolume, below) + coverage_at(below);
    return !is_solid(below) && (filled < kVoxelFull - kSupportSlack || state_at(kPlaneSupport, below) != kSupportGround);
}

// What falls in an arch thins out.
int falling_least() { return params.arch_reach > 0 ? kArchLeast : kVoxelFull; }

// Thin crumbs in the air are not worth a span each.
bool is_crumb(int column, int kind, int bottom, int top) {
    if (kind != kSpanFalling || top - bottom >= kArchShortest * kVoxelFull) return false;
    return state_at(kPlaneVolume, column + (bottom >> 16) * kTileColumns) < kVoxelFull;
}

#include "column_surface.glsl"

// index + 1 of the body that stands in a voxel if that may move, else 0.
int carrier_at(int voxel) {
    int body = owner_body(state_at(kPlaneOwner, voxel));
    return body >= 0 && shapes[body * kBodyWords + kBodyMoving] != 0 ? body + 1 : 0;
}

// Takes the lowest of a full column's spans out.
void drop_lowest_span(int record) {
    int first = record + kColumnSpans;
    for (int i = 0; i < (kSpanCapacity - 1) * kSpanWords; ++i) spans[first + i] = spans[first + i + kSpanWords];
    for (int pair = 0; pair < kSpanCapacity / 2; ++pair) {
        int at = record + kColumnBase + pair;
        int next = pair + 1 < kSpanCapacity / 2 ? spans[at + 1] : 0;
        spans[at] = ((spans[at] >> 16) & kLowHalf) | (next << 16);
    }
}

// Writes a column's next span. Where there are too many the lowest goes, so that what lies on top slips: returns the voxel in
// which that starts, else -1. base: what it stands on, see kColumnBase.
int add_span(int record, INOUT(int) count, int kind, int bottom, int top, int base) {
    int lost_at = -1;
    if (count == kSpanCapacity) {
        lost_at = min(spans[record + kColumnSpans + kSpanBottom] >> 16, params.height - 1);
        drop_lowest_span(record);
        count -= 1;
    }
    int at = record + kColumnSpans + count * kSpanWords;
    spans[at + kSpanBottom] = bottom;
    spans[at + kSpanTop] = top;
    spans[at + kSpanKind] = kind;
    int base_at = record + kColumnBase + (count >> 1);
    spans[base_at] = (count & 1) == 0 ? base : spans[base_at] | (base << 16);
    count += 1;
    return lost_at;
}

// How many voxels from the floor up are intact, where that is asked for and not known.
void count_intact(int column, int intact_at) {
    if (spans[intact_at] != kIntactUnknown || params.bank_strength <= 0) return;
    int z = 0;
    while (z < params.height && is_intact(column + z * kTileColumns)) z += 1;
    spans[intact_at] = z;
}

// Beyond a column's spans all speeds are 0.
void write_span_count(int record, int count) {
    int known = spans[record + kColumnCount];
    spans[record + kColumnCount] = count;
    for (int i = count; i < known; ++i) {
        spans[record + kColumnSpeed + i] = 0;
        spans[record + kColumnSpeed + kSpanCapacity + i] = 0;
    }
}

// The word of a column that is one pile from the floor up: its height, else kNotSingle.
int single_word(int record, int count) {
    int first = record + kColumnSpans;
    bool is_single = count == 1 && spans[first + kSpanKind] == kSpanPiled && spans[first + kSpanBottom] == 0;
    return is_single ? spans[first + kSpanTop] : kNotSingle;
}

// The multi-level heightfield, thesis Tables 1 to 3 and (30): the sorted height spans of every column. The vertical index
// grows upwards here (in the thesis it grows downwards). Heights are Q16 voxels above the floor. Edge spans depend on
// the neighbours and are made where they are used, in slip_soil. One group per tile, a lane a column.
// Columns that have not changed since the pass before have the same spans.
// Reads: coverage, owner, terrain, volume, bond, support, hollows, shapes, stamps. Writes: spans.
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
    int carrier = 0;         // see carrier_at()
    int surface = 0;         // see note_surface()
    int bare = kNotBare;
    bool climbs = false;
    bool surface_free = true;
    int lost_at = -1;        // where the highest span that does not fit starts
    for (int z = full; z <= end; ++z) {
        int voxel = column + z * kTileColumns;
        bool inside = z < end;
        int bodies = inside ? state_at(kPlaneCoverage, voxel) : 0;
        int terrain = inside ? column_terrain(column, z) : 0;
        int volume = inside ? column_volume(column, z) : 0;
        int coverage = min(kVoxelFull, bodies + terrain);
        int base = z * kVoxelFull;
        bool is_roof = begins_roof(column, z, kind, top, volume, coverage);
        int next = is_roof ? kSpanPiled : inside ? kind_above(kind, top, base, volume, coverage) : kNoSpan;
        climb_terrain(z, terrain, bare, climbs);
        if (next != kind || is_roof) {
            if (kind != kNoSpan && !is_crumb(column, kind, bottom, top)) {
                bool carried = kind == kSpanPiled && carrier > 0;
                int stands_on = !carried ? 0 : is_top_free(column, top) ? carrier | kBaseFree : carrier;
                lost_at = max(lost_at, add_span(record, count, kind, bottom, top, stands_on));
            }
            if (kind == kSpanPiled && !on_body && is_surface(bottom, top)) {
                note_surface(z, terrain, top, surface, bare, climbs);
                surface_free = is_top_free(column, top);
            }
            bottom = base;
        }
        if (next == kSpanRigid) {
            on_body = bodies > terrain;  // after the span below was closed: it stands on what is further down
            carrier = on_body ? carrier_at(voxel) : 0;
        }
        if (is_roof) carrier = 0;  // over a body in its hollow it is no surface for that
        int slack = next == kSpanPiled ? slack_at(voxel, z, volume) : kSupportSlack;
        top = top_in_voxel(next, is_roof ? kNoSpan : kind, bottom, top, base, volume, coverage, slack);
        kind = next;
    }
    count_intact(column, column_word(kColumnIntact, slot * kTileColumns + lane));
    write_span_count(record, count);
    int word = surface_word(surface, bare);
    if (bare == kNotBare && !surface_free) {
        word = bare_surface(column, full, end);
        word = word < 0 ? word : kCovered - word;
    }
    spans[column_word(kColumnSingle, slot * kTileColumns + lane)] = single_word(record, count);
    spans[column_word(kColumnSurface, slot * kTileColumns + lane)] = word;
    if (lost_at >= 0) {
        note_condition(kStatusSpansFull, kResultSpansPlace, grid_voxel(slot, lane & 7, lane >> 3, lost_at));
    }
}
